#include "runtime/debug/answer.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "runtime/base/units.h"

namespace meld::debug {

namespace {

using Json = nlohmann::ordered_json;

struct EndingWords {
    const char *name, *text;
};

EndingWords words_of(sim::Ending ending) {
    switch (ending) {
        case sim::Ending::Quiet:
            return {"quiet", "nothing is left to do"};
        case sim::Ending::Ticks:
            return {"ticks", "the last tick by the limits of the run"};
        case sim::Ending::Finished:
            return {"finished", "a catom has ended the program"};
        case sim::Ending::Interrupted:
            return {"interrupted", "interrupted"};
        case sim::Ending::Failed:
            return {"failed", "the program has failed"};
    }
    return {"", ""};
}

std::string tick_text(std::int64_t tick, const std::optional<sim::Ending>& ended) {
    return ended ? fmt::format("tick {}: {}\n", tick, words_of(*ended).text) : fmt::format("tick {}\n", tick);
}

template <class T>
Json or_null(const std::optional<T>& value) {
    return value ? Json(*value) : Json();
}

Json ending_json(const std::optional<sim::Ending>& ended) { return ended ? Json(words_of(*ended).name) : Json(); }

struct Text {
    std::string operator()(const Moved& moved) const { return tick_text(moved.tick, moved.ended); }
    std::string operator()(const FactsFound& found) const {
        std::string out;
        for (const std::string& line : found.lines) out += line + "\n";
        if (found.lines.size() < found.count) out += fmt::format("... and {} more\n", found.count - found.lines.size());
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

struct AsJson {
    Json operator()(const Moved& moved) const { return {{"from", moved.from}, {"tick", moved.tick}, {"ended", ending_json(moved.ended)}}; }
    Json operator()(const FactsFound& found) const { return {{"tick", found.tick}, {"count", found.count}, {"facts", found.lines}}; }
    Json operator()(const Standing& at) const {
        return {{"tick", at.tick},           {"first_tick", at.first_tick},
                {"catoms", at.catoms},       {"ended", ending_json(at.ended)},
                {"digest", at.digest},       {"history_bytes", at.history_bytes},
                {"snapshots", at.snapshots}, {"oldest_snapshot", or_null(at.oldest_snapshot)}};
    }
    Json operator()(const Changes& changes) const {
        Json predicates = Json::object();
        for (const Changes::Predicate& p : changes.predicates) predicates[p.name] = {{"come", p.come}, {"gone", p.gone}};
        return {{"since", changes.since}, {"tick", changes.tick}, {"predicates", std::move(predicates)}};
    }
    Json operator()(const Explained& explained) const { return {{"help", explained.text}}; }
};

std::string line(const Json& json) { return json.dump(-1, ' ', true, Json::error_handler_t::replace) + "\n"; }

}  // namespace

std::string to_text(const Answer& answer) { return std::visit(Text{}, answer); }

std::string to_json(const Answer& answer) { return line(std::visit(AsJson{}, answer)); }

std::string to_json(const Error& error) {
    return line({{"error", error.problem}, {"suggestion", error.suggestion}, {"code", static_cast<int>(error.code)}});
}

}  // namespace meld::debug
