#include "runtime/record/provenance.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace meld::record {

namespace {

using Json = nlohmann::ordered_json;

// Text may be any bytes, and JSON is UTF-8: each byte stands as the character of its number.
std::string widened(const std::string& bytes) {
    std::string text;
    for (const char c : bytes) {
        const auto byte = static_cast<unsigned char>(c);
        if (byte >= 0x80) text += static_cast<char>(0xc0 | (byte >> 6));
        text += byte >= 0x80 ? static_cast<char>(0x80 | (byte & 0x3f)) : c;
    }
    return text;
}

std::string narrowed(const std::string& text) {
    std::string bytes;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const auto byte = static_cast<unsigned char>(text[i]);
        if (byte < 0x80 || i + 1 == text.size())
            bytes += text[i];
        else
            bytes += static_cast<char>(((byte & 0x03) << 6) | (static_cast<unsigned char>(text[++i]) & 0x3f));
    }
    return bytes;
}

Json code_json(const std::vector<CodeFile>& files) {
    Json out = Json::array();
    for (const CodeFile& file : files) out.push_back({{"path", widened(file.path)}, {"hash", fmt::format("{:016x}", file.hash)}});
    return out;
}

std::vector<CodeFile> code_files(const Json& json) {
    std::vector<CodeFile> files;
    for (const Json& file : json)
        files.push_back({narrowed(file.at("path").get<std::string>()), std::stoull(file.at("hash").get<std::string>(), nullptr, 16)});
    return files;
}

Json map_json(const std::map<std::string, std::string>& map) {
    Json out = Json::object();
    for (const auto& [name, value] : map) out[widened(name)] = widened(value);
    return out;
}

std::map<std::string, std::string> map_of(const Json& json) {
    std::map<std::string, std::string> map;
    for (const auto& [name, value] : json.items()) map[narrowed(name)] = narrowed(value.get<std::string>());
    return map;
}

}  // namespace

std::string to_json(const Provenance& p) {
    Json program = Json::array(), libraries = Json::array();
    for (const Provenance::Source& source : p.program) program.push_back({{"path", widened(source.path)}, {"text", widened(source.text)}});
    for (const std::string& folder : p.libraries) libraries.push_back(widened(folder));
    Json json = {{"version", p.version},
                 {"program", program},
                 {"libraries", libraries},
                 {"optimisation", p.optimisation ? Json(*p.optimisation) : Json()},
                 {"linked", code_json(p.linked)},
                 {"extensions", code_json(p.extensions)},
                 {"world", {{"path", widened(p.world_path)}, {"text", widened(p.world)}, {"files", map_json(p.world_files)}}},
                 {"set", map_json(p.set)},
                 {"seed", p.seed},
                 {"strict", p.strict}};
    return json.dump();
}

Result<Provenance> provenance_from_json(const std::string& text) {
    const auto damaged = [] { return fail("what it takes to run it again is damaged", "", ExitCode::RecordingRefused); };
    // The library reports by exceptions what does not have the form that is asked for.
    try {
        const Json json = Json::parse(text);
        Provenance p;
        p.version = json.at("version").get<std::string>();
        for (const Json& source : json.at("program"))
            p.program.push_back({narrowed(source.at("path").get<std::string>()), narrowed(source.at("text").get<std::string>())});
        for (const Json& folder : json.at("libraries")) p.libraries.push_back(narrowed(folder.get<std::string>()));
        if (!json.at("optimisation").is_null()) p.optimisation = json.at("optimisation").get<int>();
        p.linked = code_files(json.at("linked"));
        p.extensions = code_files(json.at("extensions"));
        p.world_path = narrowed(json.at("world").at("path").get<std::string>());
        p.world = narrowed(json.at("world").at("text").get<std::string>());
        p.world_files = map_of(json.at("world").at("files"));
        p.set = map_of(json.at("set"));
        p.seed = json.at("seed").get<std::uint64_t>();
        p.strict = json.at("strict").get<bool>();
        if (p.program.empty()) return damaged();
        return p;
    } catch (const std::exception&) {
        return damaged();
    }
}

}  // namespace meld::record
