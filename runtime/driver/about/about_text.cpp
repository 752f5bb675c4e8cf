#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/base/byte_text.h"
#include "runtime/base/terminal/terminal_text.h"
#include "runtime/base/units.h"
#include "runtime/driver/about/about.h"
#include "runtime/driver/study/shell_words.h"

namespace meld::driver {

namespace {

using AboutJson = nlohmann::ordered_json;

// Counts that are always told; others if there is something to tell.
constexpr std::string_view kCountsAlwaysTold[] = {"ticks", "catoms", "messages", "evaluations", "derivations"};

struct CountLine {
    std::string name;
    std::int64_t value = 0;
};
std::vector<CountLine> counts_told(const AboutJson& counts) {
    std::vector<CountLine> told;
    for (const auto& [name, value] : counts.items()) {
        const bool always = std::ranges::find(kCountsAlwaysTold, name) != std::end(kCountsAlwaysTold);
        if (!value.is_number_integer() || (!always && value.get<std::int64_t>() == 0)) continue;
        std::string words = name;
        std::ranges::replace(words, '_', ' ');
        told.push_back({std::move(words), value.get<std::int64_t>()});
    }
    return told;
}

std::string versions_text(const AboutJson& made_by) {
    const auto version = [&](const char* name) { return made_by.value(name, std::string()); };
    std::string text = "Claymeld " + version("claymeld");
    if (const auto abi = made_by.find("module_abi"); abi != made_by.end()) text += ", module ABI " + abi->dump();
    for (const char* name : {"compiler", "mpi", "processor"})
        if (!version(name).empty()) text += ", " + version(name);
    return text;
}

std::string ticks_text(const AboutRun& about) {
    if (!about.steps) return fmt::format("{}", about.tick);
    return fmt::format("{}, in {} recorded step{}", about.tick, grouped(*about.steps), *about.steps == 1 ? "" : "s");
}

std::string hash_word(std::uint64_t hash) { return fmt::format("{:016x}", hash); }

AboutJson files_json(const std::vector<AboutRun::File>& files) {
    AboutJson all = AboutJson::array();
    for (const AboutRun::File& file : files) all.push_back({{"path", text_of_bytes(file.path)}, {"hash", hash_word(file.hash)}});
    return all;
}

AboutJson words_json(const std::vector<std::string>& words) {
    AboutJson all = AboutJson::array();
    for (const std::string& word : words) all.push_back(text_of_bytes(word));
    return all;
}

// As LaTeX has it outside of formulas; a long word may be broken after a sign.
std::string latex(std::string_view text) {
    std::string out;
    for (const char c : text) {
        if (std::string_view("#$%&_{}").find(c) != std::string_view::npos)
            out += std::string("\\") + c;
        else if (c == '\\')
            out += "\\textbackslash{}";
        else if (c == '~')
            out += "\\textasciitilde{}";
        else if (c == '^')
            out += "\\textasciicircum{}";
        else if (c == '<' || c == '>' || c == '|' || c == '"')
            out += fmt::format("\\char{}{{}}", static_cast<int>(c));
        else if (c == '\'')
            out += "\\textquotesingle{}";
        else if (c == '-')
            out += "{-}";
        else
            out += c;
    }
    return out;
}

std::string typewriter(std::string_view text) { return fmt::format("\\texttt{{{}}}", latex(text)); }

}  // namespace

std::string about_text(const AboutRun& about) {
    std::string text;
    const auto row = [&](std::string_view name, const std::string& value) {
        if (!value.empty()) text += fmt::format("{:<11} {}\n", name, visible(value));
    };
    const auto files = [&](std::string_view name, const std::vector<AboutRun::File>& all) {
        for (std::size_t i = 0; i < all.size(); ++i)
            row(i == 0 ? name : "", fmt::format("{}, hash {}", all[i].path, hash_word(all[i].hash)));
    };
    row(about.kind, about.name);
    files("program", about.program);
    files("world", about.world);
    if (about.world.empty()) row("world", "the default");
    files("code", about.code);
    row("constants", fmt::format("{}", fmt::join(about.set, ", ")));
    row("limits", fmt::format("{}", fmt::join(about.limits, ", ")));
    if (about.seed) row("seed", std::to_string(*about.seed));
    if (!about.made_by.is_null()) row("made by", versions_text(about.made_by));
    row("ticks", ticks_text(about));
    row("digest", about.digest);
    if (!about.counts.is_null()) {
        bool first = true;
        for (const CountLine& each : counts_told(about.counts)) {
            if (each.name == "ticks") continue;
            row(std::exchange(first, false) ? "counts" : "",
                fmt::format("{} {}", grouped(static_cast<std::uint64_t>(each.value)), each.name));
        }
    }
    if (!about.typed.empty())
        row("typed", shell_words(about.typed) + (about.folder.empty() ? "" : fmt::format("   (in {})", about.folder)));
    if (!about.again.empty()) row("again", shell_words(about.again));
    text += fmt::format("this {} does not contain\n", about.kind);
    for (const std::string& each : about.lacks) text += fmt::format("  - {}\n", visible(each));
    return text;
}

std::string about_json(const AboutRun& about) {
    const AboutJson json = {{"kind", about.kind},
                            {"name", text_of_bytes(about.name)},
                            {"program", files_json(about.program)},
                            {"world", files_json(about.world)},
                            {"code", files_json(about.code)},
                            {"set", words_json(about.set)},
                            {"limits", words_json(about.limits)},
                            {"seed", about.seed ? AboutJson(*about.seed) : AboutJson()},
                            {"made_by", about.made_by},
                            {"tick", about.tick},
                            {"digest", about.digest.empty() ? AboutJson() : AboutJson(about.digest)},
                            {"steps", about.steps ? AboutJson(*about.steps) : AboutJson()},
                            {"counts", about.counts},
                            {"folder", text_of_bytes(about.folder)},
                            {"typed", words_json(about.typed)},
                            {"again", words_json(about.again)},
                            {"lacks", words_json(about.lacks)}};
    return json.dump(2, ' ', true, AboutJson::error_handler_t::replace) + "\n";
}

std::string about_latex(const AboutRun& about) {
    const auto file = [](const AboutRun::File& one) {
        return fmt::format("{} (hash {})", typewriter(one.path), typewriter(hash_word(one.hash)));
    };
    std::string text = "% Needs \\usepackage{textcomp} for straight quotes.\n";
    if (!about.program.empty()) text += fmt::format("The program {} ran ", file(about.program.front()));
    text += about.world.empty() ? "in the default world" : fmt::format("in the world {}", file(about.world.front()));
    if (about.seed) text += fmt::format(", with the seed {}", *about.seed);
    if (!about.set.empty()) text += fmt::format(" and {}", typewriter(fmt::format("{}", fmt::join(about.set, ", "))));
    text += fmt::format(", for {} ticks", grouped(static_cast<std::uint64_t>(about.tick)));
    if (!about.made_by.is_null()) text += fmt::format(", by {}", latex(versions_text(about.made_by)));
    text += ".\n";
    if (!about.digest.empty())
        text += fmt::format("The digest of the state after the last tick is {}; it is the same on any number of processes and threads.\n",
                            typewriter(about.digest));
    if (!about.again.empty()) text += fmt::format("The run is made again by {}.\n", typewriter(shell_words(about.again)));
    if (about.counts.is_null()) return text;
    text += "\n\\begin{tabular}{lr}\n";
    for (const CountLine& each : counts_told(about.counts))
        text += fmt::format("{} & {} \\\\\n", latex(each.name), grouped(static_cast<std::uint64_t>(each.value)));
    return text + "\\end{tabular}\n";
}

}  // namespace meld::driver
