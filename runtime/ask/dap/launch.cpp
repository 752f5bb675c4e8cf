#include "runtime/ask/dap/launch.h"

#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <limits>
#include <string_view>

namespace meld::dap {

namespace {

namespace fs = std::filesystem;

enum class Kind { Text, Count, Switch, Texts, Values, Settings };

// An attribute that becomes an option.
struct Attribute {
    const char *name, *option;
    Kind kind;
};
constexpr std::array<Attribute, 12> kAttributes = {{
    {"world", "--world", Kind::Text},
    {"args", "--arg", Kind::Values},
    {"processes", "--processes", Kind::Count},
    {"threads", "--threads", Kind::Count},
    {"ticks", "--ticks", Kind::Count},
    {"seed", "--seed", Kind::Count},
    {"set", "--set", Kind::Settings},
    {"library", "--library", Kind::Texts},
    {"link", "--link", Kind::Texts},
    {"extension", "--extension", Kind::Texts},
    {"history", "--history", Kind::Text},
    {"strict", "--strict", Kind::Switch},
}};

tl::unexpected<Error> wrong(std::string_view name, std::string_view kind) {
    return fail(fmt::format("launch: `{}` has to be {}", name, kind));
}

// A text, number or bool as it is written on a command line.
std::optional<std::string> value_text(const Json& value) {
    if (value.is_string()) return value.get<std::string>();
    if (value.is_number() || value.is_boolean()) return value.dump();
    return std::nullopt;
}

Result<void> add(const Attribute& attribute, const Json& value, std::vector<std::string>& words) {
    const auto option = [&](const std::string& text) { words.push_back(fmt::format("{}={}", attribute.option, text)); };
    switch (attribute.kind) {
        case Kind::Text:
            if (!value.is_string()) return wrong(attribute.name, "a string");
            option(value.get<std::string>());
            break;
        case Kind::Count:
            if (!value.is_number_integer() || value.get<double>() < 0) return wrong(attribute.name, "a whole number");
            option(value.dump());
            break;
        case Kind::Switch:
            if (!value.is_boolean()) return wrong(attribute.name, "true or false");
            if (value.get<bool>()) words.emplace_back(attribute.option);
            break;
        case Kind::Texts:
        case Kind::Values:
            if (!value.is_array()) return wrong(attribute.name, "a list");
            for (const Json& each : value) {
                const auto text = attribute.kind == Kind::Texts && !each.is_string() ? std::nullopt : value_text(each);
                if (!text)
                    return wrong(attribute.name, attribute.kind == Kind::Texts ? "a list of strings" : "a list of strings and numbers");
                option(*text);
            }
            break;
        case Kind::Settings:
            if (!value.is_object()) return wrong(attribute.name, "an object of names and values");
            for (const auto& [name, each] : value.items()) {
                const auto text = value_text(each);
                if (!text) return wrong(attribute.name, "an object of names and values");
                option(name + "=" + *text);
            }
            break;
    }
    return {};
}

Result<bool> flag(const Json& arguments, const char* name, bool otherwise) {
    if (!arguments.contains(name)) return otherwise;
    if (!arguments[name].is_boolean()) return wrong(name, "true or false");
    return arguments[name].get<bool>();
}

}  // namespace

Result<Launch> read_launch(const Json& arguments) {
    Launch launch;
    if (!arguments.contains("program"))
        return fail("launch: `program` is missing", "It names a program, a recording or a folder of checkpoints");
    if (!arguments["program"].is_string() || arguments["program"] == "") return wrong("program", "a path");
    if (arguments.contains("cwd") && !arguments["cwd"].is_string()) return wrong("cwd", "a path");
    std::error_code error;
    launch.folder = arguments.value("cwd", "");
    const fs::path folder = launch.folder.empty() ? fs::current_path(error) : fs::absolute(launch.folder, error);
    launch.program = (folder / arguments["program"].get<std::string>()).lexically_normal().string();
    launch.words = {"debug", launch.program, "--served"};
    for (const Attribute& attribute : kAttributes)
        if (arguments.contains(attribute.name))
            if (auto added = add(attribute, arguments[attribute.name], launch.words); !added) return tl::unexpected<Error>(added.error());
    if (arguments.contains("optimization")) {
        if (!arguments["optimization"].is_number_unsigned()) return wrong("optimization", "a whole number");
        launch.words.push_back("-O" + arguments["optimization"].dump());
    }
    if (arguments.contains("catom")) {
        if (!arguments["catom"].is_number_unsigned()) return wrong("catom", "a whole number");
        launch.catom = arguments["catom"].get<std::uint64_t>();
    }
    const Result<bool> entry = flag(arguments, "stopOnEntry", true), plain = flag(arguments, "noDebug", false);
    if (!entry) return tl::unexpected<Error>(entry.error());
    if (!plain) return tl::unexpected<Error>(plain.error());
    launch.stop_on_entry = *entry;
    launch.debug = !*plain;
    return launch;
}

}  // namespace meld::dap
