#include "runtime/cli/usage_error.h"

#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "runtime/base/did_you_mean.h"
#include "runtime/base/terminal/terminal_text.h"
#include "runtime/cli/tables.h"

namespace meld::cli {
namespace {

// What an option is called in studies, in Python and by other programs, and here.
constexpr std::pair<std::string_view, std::string_view> kOtherNames[] = {
    {"--until", "--watch"},   {"--stop", "--watch"},       {"--assert", "--expect"},    {"--invariant", "--never"},
    {"--csv", "--facts-out"}, {"--export", "--facts-out"}, {"--output", "--facts-out"}, {"--max-ticks", "--ticks"},
    {"--np", "--processes"},  {"--ranks", "--processes"},
};

std::optional<std::string_view> named_otherwise(std::string_view option, const std::vector<std::string_view>& known) {
    for (const auto& [other, here] : kOtherNames)
        if (other == option && std::ranges::find(known, here) != known.end()) return here;
    return std::nullopt;
}

// Names the nearest option if there is one; the list of all would be long.
int no_such_option(const CLI::App& command, const std::string& where, const std::string& argument) {
    const std::string option = argument.substr(0, argument.find('='));
    std::vector<std::string> known;
    for (const OptionRow& row : options_of(command))
        for (const std::string& name : {row.short_name, row.long_name})
            if (!name.empty()) known.push_back(name);
    const std::vector<std::string_view> views(known.begin(), known.end());
    std::optional<std::string_view> near = named_otherwise(option, views);
    // A single letter is near to every other.
    if (!near && option.size() > 2) near = nearest_name(option, views);
    const std::string cure = near ? fmt::format("did you mean '{}'?", *near) : fmt::format("'{} --help' lists the options", where);
    return usage_error(where, {fmt::format("there is no option '{}'", option), cure});
}

// The option that a parser error is about, whose message starts with its name; nullptr: none.
const CLI::Option* option_of(const CLI::App& command, const std::string& message) {
    std::string_view rest = message;
    if (constexpr std::string_view kConversion = "Could not convert: "; rest.starts_with(kConversion))
        rest.remove_prefix(kConversion.size());
    const std::string name(rest.substr(0, rest.find_first_of(": ")));
    const CLI::Option* option = command.get_option_no_throw(name);
    // Some messages contain the name without its dashes.
    return option != nullptr ? option : command.get_option_no_throw("--" + name);
}

// As in the help: "-n, --processes".
std::string names_of(const CLI::Option& option) {
    if (option.get_positional()) return option.get_name();
    const std::string brief = option.get_snames().empty() ? "" : "-" + option.get_snames()[0];
    const std::string full = option.get_lnames().empty() ? "" : "--" + option.get_lnames()[0];
    return brief + (brief.empty() || full.empty() ? "" : ", ") + full;
}

// What is wrong with the value of an option, in words; empty to use the parser's own.
std::string about_value(const CLI::Option& option, const CLI::ParseError& error) {
    const std::string name = names_of(option), message = error.what();
    if (dynamic_cast<const CLI::ValidationError*>(&error) != nullptr) return name + " " + message.substr(message.find(": ") + 2);
    // Options with a type of numbers are the only ones whose text is converted.
    if (dynamic_cast<const CLI::ConversionError*>(&error) != nullptr) {
        const std::size_t equals = message.find(" = ");
        return fmt::format("{} takes a number, not '{}'", name, equals == std::string::npos ? "" : message.substr(equals + 3));
    }
    if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) == nullptr) return "";
    if (option.get_items_expected_max() == 0) return name + " takes no value";
    if (option.count() > 1) return fmt::format("{} is given {} times, and may be given only once", name, option.count());
    return fmt::format("{} needs a value, its {}", name, option.get_type_name());
}

}  // namespace

int usage_error(const std::string& where, const Error& error) {
    std::cerr << where << ": " << visible(error.message()) << "\n";
    return static_cast<int>(ExitCode::UsageOrWorld);
}

std::vector<std::string> command_names(const CLI::App& app) {
    std::vector<std::string> names;
    for (const CommandRow& command : commands_of(app)) names.push_back(command.name);
    return names;
}

int no_such_command(const CLI::App& app, const std::string& name, const Elsewhere& elsewhere) {
    const auto program = elsewhere.find(name);
    if (program != elsewhere.end())
        return usage_error(app.get_name(), {fmt::format("'{}' is a command of {}", name, program->second),
                                            fmt::format("write '{} {}'", program->second, name)});
    const std::vector<std::string> known = command_names(app);
    // A program or a world, where the command was forgotten.
    if (name.find('.') != std::string::npos)
        return usage_error(app.get_name(), {fmt::format("'{}' is no command", name),
                                            fmt::format("did you mean '{} {} {}'?", app.get_name(), known.front(), name)});
    const std::vector<std::string_view> views(known.begin(), known.end());
    return usage_error(app.get_name(), {fmt::format("there is no command '{}'", name), did_you_mean(name, views)});
}

int report_usage(const CLI::App& app, const CLI::ParseError& error, int argc, const char* const* argv, const Elsewhere& elsewhere) {
    const std::vector<CLI::App*> chosen = const_cast<CLI::App&>(app).get_subcommands();
    if (chosen.empty() && !app.get_subcommands([](const CLI::App*) { return true; }).empty()) {
        if (argc > 1 && argv[1][0] != '-') return no_such_command(app, argv[1], elsewhere);
        if (argc == 1) return usage_error(app.get_name(), {"a command is needed", fmt::format("'{} help' lists them", app.get_name())});
    }
    const CLI::App& command = chosen.empty() ? app : *chosen.back();
    const std::string where = app.get_name() + (chosen.empty() ? "" : " " + command.get_name());
    const std::vector<std::string> unknown = app.remaining(true);
    const auto stray =
        std::find_if(unknown.begin(), unknown.end(), [](const std::string& word) { return word.size() > 1 && word[0] == '-'; });
    if (stray != unknown.end()) return no_such_option(command, where, *stray);
    const std::string see_help = fmt::format("see '{} --help'", where);
    if (!unknown.empty() && dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr)
        return usage_error(where, {fmt::format("'{}' is one argument too many", unknown[0]), see_help});
    const CLI::Option* option = option_of(command, error.what());
    const std::string about = option == nullptr ? "" : about_value(*option, error);
    return usage_error(where, {about.empty() ? error.what() : about, see_help});
}

}  // namespace meld::cli
