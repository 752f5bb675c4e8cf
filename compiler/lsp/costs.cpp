#include "compiler/lsp/costs.h"

#include <fmt/format.h>

#include <system_error>

#include "runtime/base/shallow_json.h"
#include "runtime/base/units.h"

namespace meld::lsp {

namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

fs::file_time_type written(const std::string& path) {
    std::error_code none;
    return fs::last_write_time(path, none);
}

// As item_text() has it, whatever blanks and comments it was written with.
std::string on_one_line(const std::string& rule) {
    source::FileSet files;
    const std::uint32_t file = files.add("", rule);
    const FileTokens tokens = read_items(files.file(file), file);
    return tokens.items.empty() ? "" : item_text(files.file(file), tokens, 0);
}

bool before(Position a, Position b) { return a.line != b.line ? a.line < b.line : a.character < b.character; }

std::string label(const Cost& cost, double all_seconds) {
    if (cost.counted && cost.firings == 0) return "never fired";
    std::string text;
    if (cost.cpu_seconds > 0) text = fmt::format("{:.1f} % of the time", 100 * cost.cpu_seconds / all_seconds);
    if (!cost.counted) return text;
    if (!text.empty()) text += ", ";
    text += fmt::format("{} firing{}", grouped(cost.firings), cost.firings == 1 ? "" : "s");
    if (cost.messages > 0) text += fmt::format(", {} message{}", grouped(cost.messages), cost.messages == 1 ? "" : "s");
    return text;
}

std::string table(const Cost& cost, const std::string& path) {
    std::string text = "| in the run | |\n|---|--:|\n";
    const auto row = [&](const char* name, const std::string& value) { text += fmt::format("| {} | {} |\n", name, value); };
    if (cost.counted) {
        row("evaluations", grouped(cost.evaluations));
        row("firings", grouped(cost.firings));
        row("derivations", grouped(cost.derivations));
        row("messages over links", grouped(cost.messages));
        row("bits over links", grouped(cost.bits));
    }
    row("CPU time, by samples", format_duration(cost.cpu_seconds));
    return text + "\nFrom `" + path + "`.";
}

}  // namespace

Result<Costs> Costs::read(const std::string& path) {
    Costs costs;
    costs.path_ = path;
    costs.written_ = written(path);
    const Result<profile::Profile> profile = profile::read_profile(path);
    if (!profile) return tl::unexpected(profile.error());
    try {
        const bool counted = profile->statistics.at("algorithm").contains("messages");
        for (const Json& rule : profile->statistics.at("rules")) {
            const std::string file = rule.at("file").get<std::string>();
            const double seconds = rule.at("cpu_seconds").get<double>();
            costs.seconds_ += seconds;
            // What the compiler has made stands in no file.
            if (file.empty()) continue;
            Cost& cost = costs.rules_[{fs::path(file).filename().string(), on_one_line(rule.at("text").get<std::string>())}];
            cost.cpu_seconds += seconds;
            cost.counted = counted;
            if (!counted) continue;
            cost.evaluations += whole_number<std::uint64_t>(rule.at("evaluations"));
            cost.firings += whole_number<std::uint64_t>(rule.at("firings"));
            cost.derivations += whole_number<std::uint64_t>(rule.at("derivations"));
            cost.messages += whole_number<std::uint64_t>(rule.at("messages"));
            cost.bits += whole_number<std::uint64_t>(rule.at("bits"));
        }
    } catch (const Json::exception& error) {
        return profile::part_missing(path, error);
    }
    return costs;
}

bool Costs::outdated() const {
    std::error_code error;
    const fs::file_time_type now = fs::last_write_time(path_, error);
    return !error && now != written_;
}

std::vector<CostHint> Costs::hints(const Analysis& analysis, Range range) const {
    const FileTokens& tokens = analysis.tokens().at(analysis.root_index());
    const std::string file = fs::path(analysis.root().path()).filename().string();
    std::vector<CostHint> list;
    for (std::size_t i = 0; i < tokens.items.size(); ++i) {
        if (tokens.items[i].kind != TokenKind::Name) continue;
        const Position end = position_of(analysis.root(), tokens.tokens[tokens.items[i].end - 1].span.end);
        if (before(end, range.start) || before(range.end, end)) continue;
        const auto cost = rules_.find({file, analysis.item_text(analysis.root_index(), i)});
        if (cost == rules_.end()) continue;
        // Without counts there is nothing to say of a rule that no sample has met.
        std::string said = label(cost->second, seconds_);
        if (!said.empty()) list.push_back({end, std::move(said), table(cost->second, path_)});
    }
    return list;
}

}  // namespace meld::lsp
