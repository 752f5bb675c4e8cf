#include "runtime/ask/dap/place.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "runtime/ask/dap/text.h"

namespace meld::dap {

namespace {

// Frames further down are not looked at by anybody.
constexpr int kDepth = 30;
// So many ways in which a rule has fired are shown.
constexpr std::size_t kMaxWays = 10;

// The digits of the catom in "dist(@4, 0 + 1)".
std::string site_of(std::string_view head) {
    const std::size_t open = head.find('(');
    if (open == std::string_view::npos) return {};
    return std::string(catom_in(head.substr(open + 1, std::min(head.find_first_of(",)"), head.size()) - open - 1)));
}

}  // namespace

void Place::choose(std::uint64_t catom) {
    catom_ = catom;
    before_ = nullptr;
    if (!explained_) forget();
}

// What was made for the client means nothing from now on.
void Place::forget() {
    built_ = false;
    frames_.clear();
    table_.clear();
    derivation_.reset();
}

void Place::leave() {
    const Result<Json> now = facts();
    before_ = now ? now->at("facts") : Json(nullptr);
}

void Place::arrive(const Json& moved) {
    forget();
    explained_ = false;
    tick_ = moved.at("tick").get<std::int64_t>();
    from_ = moved.value("from", tick_);
    stops_ = moved.value("stops", Json::array());
}

void Place::explain(const Json& why) {
    forget();
    explained_ = true;
    stops_ = Json::array();
    derivation_.emplace(why);
}

Result<Json> Place::facts(const std::string& predicate) {
    return run_.ask(fmt::format("facts @{}{}{}", catom_, predicate.empty() ? "" : " ", predicate));
}

// The first fact of the chosen catom that has come by a rule on the way here; empty: there is none.
std::string Place::new_fact() {
    if (tick_ <= from_ || before_.is_null()) return {};
    const Result<Json> now = facts();
    if (!now) return {};
    for (const Json& fact : now->at("facts"))
        if (rules_.derive(predicate_of(fact.get<std::string>())) && std::ranges::find(before_, fact) == before_.end()) {
            auto text = fact.get<std::string>();
            if (text.ends_with('.')) text.pop_back();
            return text;
        }
    return {};
}

// A rule that has fired is the top of the stack, with what its variables were.
void Place::add_stop(const Json& stop) {
    const auto what = stop.at("what").get<std::string>();
    const auto found = std::ranges::find_if(rules_.all(), [&](const Rule& rule) {
        return what == fmt::format("{}:{}", std::filesystem::path(rule.file).filename().string(), rule.line);
    });
    const Json& ways = stop.at("ways");
    const std::string way = ways.empty() ? "" : ways[0].get<std::string>();
    const auto values = bindings_in(way);
    Frame frame{.name = way.empty() ? what : fmt::format("{}: {}", what, way)};
    for (const auto& [name, value] : values) frame.bindings.push_back({.name = name, .value = value});
    for (std::size_t i = 1; i < std::min(ways.size(), kMaxWays); ++i)
        frame.bindings.push_back({.name = fmt::format("also {}", i), .value = ways[i].get<std::string>()});
    if (const auto more = stop.value("more", std::size_t{0}) + ways.size(); more > kMaxWays)
        frame.bindings.push_back({.name = "...", .value = fmt::format("and {} more", more - kMaxWays)});
    if (found != rules_.all().end()) {
        frame.rule = &*found;
        if (const std::string site = site_of(with_values(head_of(found->text), values)); !site.empty()) catom_ = std::stoull(site);
        for (const std::string& atom : atoms_of(found->text)) {
            if (!rules_.derive(predicate_of(atom))) continue;
            const Result<Json> why = ask_line(run_, fmt::format("why --no-replay --depth {} {}", kDepth, with_values(atom, values)));
            if (!why || why->at("roots").empty()) continue;
            derivation_.emplace(*why);
            break;
        }
    }
    // What a linear rule has consumed is gone, so nothing can be asked about it, but its catom is known.
    if (stop.contains("at") && !stop["at"].empty()) catom_ = stop["at"][0].get<std::uint64_t>();
    frames_.push_back(std::move(frame));
}

void Place::add_derivation() {
    for (const Derivation::Frame& each : derivation_->frames(rules_))
        frames_.push_back({.name = each.fact, .rule = each.rule, .node = each.node});
}

void Place::build() {
    if (built_) return;
    built_ = true;
    if (!stops_.empty()) add_stop(stops_[0]);
    if (!derivation_ && stops_.empty())
        if (const std::string fact = new_fact(); !fact.empty())
            if (const auto why = ask_line(run_, fmt::format("why --no-replay --depth {} {}", kDepth, fact)); why) derivation_.emplace(*why);
    if (derivation_) add_derivation();
    frames_.push_back({.name = fmt::format("tick {}", tick_)});
}

Result<Json> Place::stack(std::size_t start, std::size_t levels) {
    build();
    Json list = Json::array();
    for (std::size_t i = start; i < frames_.size() && (levels == 0 || i - start < levels); ++i) {
        const Frame& frame = frames_[i];
        Json json = {{"id", i + 1}, {"name", frame.name}, {"line", 0}, {"column", 0}};
        if (frame.rule != nullptr && !frame.rule->path.empty()) {
            json["source"] = source_of(*frame.rule);
            json["line"] = frame.rule->line;
            json["endLine"] = frame.rule->last_line;
            json["column"] = 1;
        } else if (frame.rule == nullptr && frames_.size() == 1 && !program_.empty()) {
            // Some clients show no values unless a frame has a place.
            json["source"] = {{"name", std::filesystem::path(program_).filename().string()}, {"path", program_}};
            json["line"] = json["column"] = 1;
        } else {
            json["presentationHint"] = "subtle";
        }
        list.push_back(std::move(json));
    }
    return Json{{"stackFrames", std::move(list)}, {"totalFrames", frames_.size()}};
}

Result<Json> Place::scopes(std::int64_t frame) {
    build();
    if (frame < 1 || std::cmp_greater(frame, frames_.size())) return fail(fmt::format("there is no frame {} in this tick", frame));
    const Frame& of = frames_[static_cast<std::size_t>(frame) - 1];
    Json list = Json::array();
    const auto add = [&](const std::string& name, VariableTable::Make make, bool costly = false) {
        list.push_back({{"name", name}, {"variablesReference", table_.add(std::move(make))}, {"expensive", costly}});
    };
    if (!of.bindings.empty()) add("Variables of the rule", [variables = of.bindings] { return variables; });
    if (of.node) add("Rests on", [this, node = *of.node] { return derivation_->rests_on(node, table_); });
    add(fmt::format("@{}", catom_), [this] { return catom_scope(); });
    add("Run", [this] { return run_variables(); });
    return Json{{"scopes", std::move(list)}};
}

Result<Variables> Place::catom_scope() {
    const Result<Json> found = facts();
    if (!found) return tl::unexpected<Error>(found.error());
    Variables out = facts_by_predicate(*found, table_);
    if (found->contains("catom"))
        for (Variable& each : catom_variables(found->at("catom"), table_)) out.push_back(std::move(each));
    return out;
}

Result<Variables> Place::run_variables() {
    const Result<Json> at = run_.ask("where");
    if (!at) return tl::unexpected<Error>(at.error());
    Variables out;
    out.push_back({.name = "catom", .value = fmt::format("@{}", catom_), .type = "The catom whose facts are shown", .changeable = true});
    for (const char* const name : {"tick", "first_tick", "catoms"}) out.push_back({.name = name, .value = at->at(name).dump()});
    for (const char* const name : {"digest", "ended"})
        if (at->at(name).is_string()) out.push_back({.name = name, .value = at->at(name).get<std::string>()});
    out.push_back(
        {.name = "snapshots", .value = fmt::format("{} in {} bytes", at->at("snapshots").dump(), at->at("history_bytes").dump())});
    return out;
}

}  // namespace meld::dap
