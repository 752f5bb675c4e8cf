#include "runtime/ask/debug/answer.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include <nlohmann/json.hpp>

#include "runtime/base/units.h"
#include "runtime/sim/ending_name.h"

namespace meld::debug {

namespace {

using Json = nlohmann::ordered_json;

const char* text_of(sim::Ending ending) {
    switch (ending) {
        case sim::Ending::Quiet:
            return "nothing is left to do";
        case sim::Ending::Ticks:
            return "the last tick by the limits of the run";
        case sim::Ending::Finished:
            return "a catom has ended the program";
        case sim::Ending::Watched:
            return "the end by what is watched";
        case sim::Ending::Interrupted:
            return "interrupted";
        case sim::Ending::Failed:
            return "the program has failed";
    }
    return "";
}

std::string tick_text(std::int64_t tick, const std::optional<sim::Ending>& ended) {
    return ended ? fmt::format("tick {}: {}\n", tick, text_of(*ended)) : fmt::format("tick {}\n", tick);
}

template <class T>
Json or_null(const std::optional<T>& value) {
    return value ? Json(*value) : Json();
}

Json ending_json(const std::optional<sim::Ending>& ended) { return ended ? Json(sim::name_of(*ended)) : Json(); }

// As comments of Meld, before its facts.
std::string catom_text(const inspect::CatomState& at) {
    std::string out = fmt::format("// @{} ", at.id);
    out += at.cell ? fmt::format("in cell ({}, {}, {})", (*at.cell)[0], (*at.cell)[1], (*at.cell)[2])
                   : fmt::format("at ({:.3f}, {:.3f}, {:.3f})", at.position[0], at.position[1], at.position[2]);
    if (at.links.empty()) out += ", touches nothing";
    for (std::size_t i = 0; i < at.links.size(); ++i)
        out += fmt::format("{} @{} at port {}",
                           i == 0                     ? ", touches"
                           : i + 1 == at.links.size() ? " and"
                                                      : ",",
                           at.links[i].catom, at.links[i].port);
    out += "\n";
    for (const std::string& action : at.actions) out += fmt::format("// asks for {}\n", action);
    for (const auto& coming : at.coming) out += fmt::format("// {} comes in tick {}\n", coming.fact, coming.tick);
    return out;
}

Json catom_json(const inspect::CatomState& at) {
    Json links = Json::array(), coming = Json::array();
    for (const auto& link : at.links) links.push_back({{"port", link.port}, {"catom", link.catom}});
    for (const auto& fact : at.coming) coming.push_back({{"fact", fact.fact}, {"tick", fact.tick}});
    return {{"id", at.id},    {"cell", or_null(at.cell)}, {"position", at.position},
            {"links", links}, {"actions", at.actions},    {"coming", coming}};
}

// So many ways of one break are shown to people.
constexpr std::size_t kMostWays = 10;

std::string stop_text(const Stop& stop) {
    std::string out;
    const std::string name = stop.number ? fmt::format("{}: {}", *stop.number, stop.what) : "until " + stop.what;
    for (std::size_t i = 0; i < std::min(stop.ways.size(), kMostWays); ++i)
        out += fmt::format("{}{}{}{}\n", name, stop.at.empty() ? "" : fmt::format(" at @{}", stop.at[i]), stop.ways[i].empty() ? "" : ": ",
                           stop.ways[i]);
    if (stop.ways.size() > kMostWays) out += fmt::format("{}: and {} more\n", name, stop.ways.size() - kMostWays);
    return out;
}

// 20 facts of visited and 1 of token
std::string counted(const std::map<std::string, std::uint64_t>& facts) {
    std::string out;
    std::size_t left = facts.size();
    for (const auto& [name, count] : facts) {
        const bool first = out.empty();
        out += first ? "" : --left == 1 ? " and " : ", ";
        out += first ? fmt::format("{} fact{} of {}", count, count == 1 ? "" : "s", name) : fmt::format("{} of {}", count, name);
    }
    return out;
}

struct Text {
    std::string operator()(const Moved& moved) const {
        std::string out = moved.branch.empty() ? "" : fmt::format("branch {}: ", moved.branch);
        out += tick_text(moved.tick, moved.ended);
        for (const Stop& stop : moved.stops) out += stop_text(stop);
        return out;
    }
    std::string operator()(const BreaksFound& found) const {
        std::string out;
        for (const BreaksFound::One& one : found.breaks) {
            out += fmt::format("{}: {} {}\n", one.number, one.rule ? "break" : "watch", one.what);
            for (const std::string& rule : one.rules) out += fmt::format("   {}\n", rule);
        }
        return out.empty() ? "no breaks and no watches\n" : out;
    }
    std::string operator()(const EventsFound& found) const {
        std::string out;
        for (const EventsFound::One& one : found.events) {
            const std::string count = one.struck.size() > (one.links ? 2 : 1) ? fmt::format(" ({} catoms)", one.struck.size()) : "";
            out += fmt::format("tick {}: {} {}{}\n", one.tick, one.verb, one.fact, count);
        }
        if (found.dropped > 0)
            out += fmt::format("dropped: {} of later ticks, which {} done by hand\n", found.dropped, found.dropped == 1 ? "was" : "were");
        return out.empty() ? "nothing has been done by hand\n" : out;
    }
    std::string operator()(const Written& written) const {
        return fmt::format("{}: {} {}{}\n", written.path, written.count, written.what, written.count == 1 ? "" : "s");
    }
    std::string operator()(const Reloaded& done) const {
        if (!done.changed) return done.messages + fmt::format("tick {}: the program is the one that there was\n", done.tick);
        std::string out = done.messages + fmt::format("tick {}: goes on with the program as it is now\n", done.tick);
        if (!done.facts.taken_over.empty()) out += fmt::format("taken over: {}\n", counted(done.facts.taken_over));
        if (!done.facts.dropped.empty()) out += fmt::format("dropped: {}\n", counted(done.facts.dropped));
        if (!done.facts.derived_anew.empty()) out += fmt::format("derived anew: {}\n", fmt::join(done.facts.derived_anew, ", "));
        for (const BreaksFound::One& one : done.lost)
            out += fmt::format("gone: {}: {} {}\n", one.number, one.rule ? "break" : "watch", one.what);
        if (!done.branches.empty()) out += fmt::format("branches that are gone: {}\n", fmt::join(done.branches, ", "));
        return out;
    }
    std::string operator()(const BranchesFound& found) const {
        std::string out;
        for (const BranchesFound::One& one : found.branches) {
            const std::string by_hand = one.events == 0 ? "" : fmt::format(", {} event{} by hand", one.events, one.events == 1 ? "" : "s");
            out += fmt::format("{} {}: tick {}{}\n", one.present ? "*" : " ", one.name, one.tick, by_hand);
        }
        return out;
    }
    std::string operator()(const Saved& saved) const { return fmt::format("{}: a checkpoint of tick {}\n", saved.folder, saved.tick); }
    std::string operator()(const FactsFound& found) const {
        std::string out = found.catom ? catom_text(*found.catom) : "";
        for (const std::string& line : found.lines) out += line + "\n";
        if (found.lines.size() < found.count) out += fmt::format("... and {} more\n", found.count - found.lines.size());
        return out;
    }
    std::string operator()(const RowsFound& rows) const {
        std::string out = rows.table.to_text(rows.most_rows);
        if (rows.table.failures > 0)
            out += fmt::format("left out: {} value{} that cannot be computed, the first for {}\n", rows.table.failures,
                               rows.table.failures == 1 ? "" : "s", rows.table.first_failure);
        return out;
    }
    std::string operator()(const WhyFound& found) const {
        const inspect::Explanation& why = found.explanation;
        if (!why.roots.empty()) return why.to_text();
        return found.holds ? fmt::format("{} does not hold after tick {}; why-not tells more\n", why.asked, why.tick)
                           : fmt::format("{} holds after tick {}; why tells more\n", why.asked, why.tick);
    }
    std::string operator()(const inspect::Comings& found) const { return found.to_text(); }
    std::string operator()(const inspect::Messages& found) const { return found.to_text(); }
    std::string operator()(const Consequences& found) const {
        std::string out = fmt::format("{} taken in tick {}\nwith it     {}without it  {}", found.fact, found.tick + 1,
                                      tick_text(found.with.tick, found.with.ended), tick_text(found.without.tick, found.without.ended));
        if (found.predicates.empty()) out += "no other fact depends on it\n";
        std::uint64_t left = 0;
        for (const Changes::Predicate& p : found.predicates) {
            out += fmt::format("{}: +{} -{}\n", p.name, p.come, p.gone);
            left += p.come + p.gone;
        }
        for (const std::string& fact : found.gone) out += "-" + fact + "\n";
        for (const std::string& fact : found.came) out += "+" + fact + "\n";
        left -= found.gone.size() + found.came.size();
        if (left > 0) out += fmt::format("... and {} more\n", left);
        return out;
    }
    std::string operator()(const RulesListed& listed) const {
        std::string out;
        for (const RulesListed::Rule& rule : listed.rules) out += fmt::format("{}:{}: {}\n", rule.file, rule.line, rule.text);
        return out.empty() ? "no rule\n" : out;
    }
    std::string operator()(const PredicatesListed& listed) const {
        std::string out;
        for (const bool own : {true, false})
            for (const PredicatesListed::Predicate& p : listed.predicates)
                if (p.own == own) out += p.declaration + ".\n";
        return out;
    }
    std::string operator()(const Standing& at) const {
        std::string out = tick_text(at.tick, at.ended);
        out += fmt::format("catoms   {}\ndigest   {}\n", at.catoms, at.digest);
        if (at.first_tick > 0) out += fmt::format("begins   with tick {}\n", at.first_tick);
        if (at.snapshots == 0) return out + "history  no snapshot\n";
        return out + fmt::format("history  {} in {} snapshot{}, the oldest of tick {}\n", format_bytes(at.history_bytes), at.snapshots,
                                 at.snapshots == 1 ? "" : "s", *at.oldest_snapshot);
    }
    std::string operator()(const Changes& changes) const {
        std::string out = fmt::format("from tick {} to tick {}:{}\n", changes.since, changes.tick,
                                      changes.predicates.empty() ? " no fact has changed" : "");
        for (const Changes::Predicate& p : changes.predicates) out += fmt::format("{}: +{} -{}\n", p.name, p.come, p.gone);
        return out;
    }
    std::string operator()(const Explained& explained) const { return explained.text; }
};

Json changes_json(const std::vector<Changes::Predicate>& predicates) {
    Json out = Json::object();
    for (const Changes::Predicate& p : predicates) out[p.name] = {{"come", p.come}, {"gone", p.gone}};
    return out;
}

struct AsJson {
    Json operator()(const Moved& moved) const {
        Json json = {{"from", moved.from}, {"tick", moved.tick}, {"ended", ending_json(moved.ended)}};
        if (!moved.branch.empty()) json["branch"] = moved.branch;
        for (const Stop& stop : moved.stops) {
            Json& one = json["stops"].emplace_back(Json{{"number", or_null(stop.number)}, {"what", stop.what}, {"ways", stop.ways}});
            if (!stop.at.empty()) one["at"] = stop.at;
        }
        return json;
    }
    Json operator()(const BreaksFound& found) const {
        Json all = Json::array();
        for (const BreaksFound::One& one : found.breaks)
            all.push_back({{"number", one.number}, {"kind", one.rule ? "break" : "watch"}, {"what", one.what}, {"rules", one.rules}});
        return {{"breaks", std::move(all)}};
    }
    Json operator()(const EventsFound& found) const {
        Json events = Json::array();
        for (const EventsFound::One& one : found.events) {
            Json& event = events.emplace_back(Json{{"tick", one.tick}, {"kind", one.verb}});
            if (one.struck.empty())
                event["fact"] = one.fact;
            else
                event["catoms"] = one.struck;
            if (one.ticks) event["ticks"] = *one.ticks;
        }
        return {{"tick", found.tick}, {"dropped", found.dropped}, {"events", std::move(events)}};
    }
    Json operator()(const Written& written) const { return {{"written", written.path}, {written.what + "s", written.count}}; }
    Json operator()(const Reloaded& done) const {
        return {{"tick", done.tick},
                {"reloaded", done.changed},
                {"taken_over", done.facts.taken_over},
                {"dropped", done.facts.dropped},
                {"derived_anew", done.facts.derived_anew},
                {"gone", (*this)(BreaksFound{done.lost})["breaks"]},
                {"branches_gone", done.branches},
                {"messages", done.messages}};
    }
    Json operator()(const BranchesFound& found) const {
        Json list = Json::array();
        for (const BranchesFound::One& one : found.branches)
            list.push_back({{"name", one.name}, {"tick", one.tick}, {"events", one.events}, {"present", one.present}});
        return {{"branches", list}};
    }
    Json operator()(const Saved& saved) const {
        return {{"saved", saved.folder},
                {"tick", saved.tick},
                {"digest", saved.digest},
                {"events", saved.events.empty() ? Json() : Json(saved.events)}};
    }
    Json operator()(const FactsFound& found) const {
        Json json = {{"tick", found.tick}, {"count", found.count}};
        if (found.catom) json["catom"] = catom_json(*found.catom);
        json["facts"] = found.lines;
        return json;
    }
    Json operator()(const RowsFound& rows) const {
        Json json = {{"tick", rows.tick},
                     {"query", rows.body},
                     {"columns", rows.table.columns_json()},
                     {"count", rows.table.rows()},
                     {"rows", rows.table.rows_json(rows.most_rows)}};
        if (rows.table.failures > 0) json["left_out"] = {{"count", rows.table.failures}, {"first", rows.table.first_failure}};
        return json;
    }
    Json operator()(const WhyFound& found) const {
        Json json = {{found.holds ? "why" : "why_not", found.explanation.asked}};
        json.update(found.explanation.to_json());
        json.erase("asked");
        return json;
    }
    Json operator()(const inspect::Comings& found) const { return found.to_json(); }
    Json operator()(const inspect::Messages& found) const { return found.to_json(); }
    Json operator()(const Consequences& found) const {
        const auto run = [](const Consequences::Run& one) { return Json{{"tick", one.tick}, {"ended", ending_json(one.ended)}}; };
        return {{"depends", found.fact},
                {"tick", found.tick},
                {"with", run(found.with)},
                {"without", run(found.without)},
                {"predicates", changes_json(found.predicates)},
                {"gone", found.gone},
                {"came", found.came}};
    }
    Json operator()(const RulesListed& listed) const {
        Json rules = Json::array();
        for (const RulesListed::Rule& r : listed.rules)
            rules.push_back({{"name", r.name},
                             {"text", r.text},
                             {"file", r.file},
                             {"library", r.library},
                             {"line", r.line},
                             {"last_line", r.last_line}});
        return {{"rules", std::move(rules)}};
    }
    Json operator()(const PredicatesListed& listed) const {
        Json predicates = Json::array();
        for (const PredicatesListed::Predicate& p : listed.predicates)
            predicates.push_back({{"name", p.name}, {"declaration", p.declaration}, {"own", p.own}});
        return {{"predicates", std::move(predicates)}};
    }
    Json operator()(const Standing& at) const {
        return {{"tick", at.tick},           {"first_tick", at.first_tick},
                {"catoms", at.catoms},       {"ended", ending_json(at.ended)},
                {"digest", at.digest},       {"history_bytes", at.history_bytes},
                {"snapshots", at.snapshots}, {"oldest_snapshot", or_null(at.oldest_snapshot)}};
    }
    Json operator()(const Changes& changes) const {
        return {{"since", changes.since}, {"tick", changes.tick}, {"predicates", changes_json(changes.predicates)}};
    }
    Json operator()(const Explained& explained) const { return {{"help", explained.text}}; }
};

std::string line(const Json& json) { return json.dump(-1, ' ', true, Json::error_handler_t::replace) + "\n"; }

}  // namespace

std::string to_text(const Answer& answer) { return std::visit(Text{}, answer); }

std::string to_json(const Answer& answer) { return line(std::visit(AsJson{}, answer)); }

std::string to_json_with_text(const Answer& answer) {
    Json json = std::visit(AsJson{}, answer);
    json["text"] = to_text(answer);
    // A rule may fire everywhere at once.
    if (json.contains("stops"))
        for (Json& stop : json["stops"]) {
            const std::size_t count = stop["ways"].size();
            if (count <= kMostWays) continue;
            for (const char* list : {"ways", "at"})
                if (stop.contains(list)) stop[list].erase(stop[list].begin() + static_cast<std::ptrdiff_t>(kMostWays), stop[list].end());
            stop["more"] = count - kMostWays;
        }
    return line(json);
}

std::string to_json(const Error& error) {
    return line({{"error", error.problem}, {"suggestion", error.suggestion}, {"code", static_cast<int>(error.code)}});
}

}  // namespace meld::debug
