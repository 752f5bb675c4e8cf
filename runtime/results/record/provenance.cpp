#include "runtime/results/record/provenance.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "runtime/base/byte_text.h"
#include "runtime/base/shallow_json.h"

namespace meld::record {

namespace {

using Json = nlohmann::ordered_json;

Json code_json(const std::vector<CodeFile>& files) {
    Json out = Json::array();
    for (const CodeFile& file : files) out.push_back({{"path", text_of_bytes(file.path)}, {"hash", fmt::format("{:016x}", file.hash)}});
    return out;
}

std::vector<CodeFile> code_files(const Json& json) {
    std::vector<CodeFile> files;
    for (const Json& file : json)
        files.push_back({bytes_of_text(file.at("path").get<std::string>()), std::stoull(file.at("hash").get<std::string>(), nullptr, 16)});
    return files;
}

Json map_json(const std::map<std::string, std::string>& map) {
    Json out = Json::object();
    for (const auto& [name, value] : map) out[text_of_bytes(name)] = text_of_bytes(value);
    return out;
}

std::map<std::string, std::string> map_of(const Json& json) {
    std::map<std::string, std::string> map;
    for (const auto& [name, value] : json.items()) map[bytes_of_text(name)] = bytes_of_text(value.get<std::string>());
    return map;
}

}  // namespace

std::string to_json(const Provenance& p) {
    Json program = Json::array(), libraries = Json::array();
    for (const Provenance::Source& source : p.program)
        program.push_back({{"path", text_of_bytes(source.path)}, {"text", text_of_bytes(source.text)}});
    for (const std::string& folder : p.libraries) libraries.push_back(text_of_bytes(folder));
    Json json = {{"version", p.version},
                 {"forked_from", text_of_bytes(p.forked_from)},
                 {"program", program},
                 {"programs", p.programs},
                 {"libraries", libraries},
                 {"optimisation", p.optimisation ? Json(*p.optimisation) : Json()},
                 {"linked", code_json(p.linked)},
                 {"extensions", code_json(p.extensions)},
                 {"world", {{"path", text_of_bytes(p.world_path)}, {"text", text_of_bytes(p.world)}, {"files", map_json(p.world_files)}}},
                 {"set", map_json(p.set)},
                 {"limits", p.limits},
                 {"seed", p.seed},
                 {"ports", p.ports},
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
        p.forked_from = bytes_of_text(json.at("forked_from").get<std::string>());
        for (const Json& source : json.at("program"))
            p.program.push_back({bytes_of_text(source.at("path").get<std::string>()), bytes_of_text(source.at("text").get<std::string>())});
        p.programs = whole_number<std::uint32_t>(json.at("programs"));
        for (const Json& folder : json.at("libraries")) p.libraries.push_back(bytes_of_text(folder.get<std::string>()));
        if (!json.at("optimisation").is_null()) p.optimisation = whole_number<int>(json.at("optimisation"));
        p.linked = code_files(json.at("linked"));
        p.extensions = code_files(json.at("extensions"));
        p.world_path = bytes_of_text(json.at("world").at("path").get<std::string>());
        p.world = bytes_of_text(json.at("world").at("text").get<std::string>());
        p.world_files = map_of(json.at("world").at("files"));
        p.set = map_of(json.at("set"));
        if (json.contains("limits")) p.limits = json.at("limits").get<std::vector<std::string>>();
        p.seed = whole_number<std::uint64_t>(json.at("seed"));
        // Recordings of earlier versions do not have it.
        p.ports = json.value("ports", std::string(kLatticePorts));
        p.strict = json.at("strict").get<bool>();
        if (p.programs == 0 || p.programs > p.program.size()) return damaged();
        return p;
    } catch (const std::exception&) {
        return damaged();
    }
}

}  // namespace meld::record
