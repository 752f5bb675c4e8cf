// A history for people and for programs.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "runtime/ask/why/history.h"

namespace meld::inspect {

namespace {

using Json = nlohmann::ordered_json;
using Change = Comings::Change;
using How = Change::How;
using Way = Explanation::Way;

const char* name_of(How how) {
    switch (how) {
        case How::Derived:
            return "derived";
        case How::Made:
            return "made";
        case How::Given:
            return "given";
        case How::Sensed:
            return "sensed";
        case How::Replaced:
            return "replaced";
        case How::Lost:
            return "lost";
        case How::Consumed:
            return "consumed";
        case How::Taken:
            return "taken";
        case How::Gone:
            return "gone";
        case How::Unknown:
            return "unknown";
    }
    return "";
}

// Several views give what is combined; of several firings one has been.
std::string rules_text(const Change& change) {
    const char* const between = change.how == How::Derived || change.how == How::Lost ? " and " : " or ";
    std::string out;
    for (std::size_t i = 0; i < change.rules.size(); ++i) {
        const Way& way = change.rules[i];
        out += fmt::format("{}{}:{}", i == 0 ? "" : between, way.file, way.line);
        if (way.catom) out += fmt::format(" at @{}", *way.catom);
    }
    if (change.more > 0) out += fmt::format(" or in {} more ways", change.more);
    return out;
}

std::string cause(const Change& change) {
    switch (change.how) {
        case How::Derived:
        case How::Made:
            return "by " + rules_text(change);
        case How::Given:
        case How::Sensed:
        case How::Taken:
            return name_of(change.how);
        case How::Replaced:
            return "replaced by " + change.by;
        case How::Lost:
            return "no longer by " + rules_text(change);
        case How::Consumed:
            return "consumed by " + rules_text(change);
        case How::Gone:
            return "gone with its catom";
        case How::Unknown:
            return "";
    }
    return "";
}

}  // namespace

std::string Comings::to_text() const {
    std::string out;
    for (const std::string& fact : at_first) out += fmt::format("tick {:<6} {} is there\n", first_tick, fact);
    for (const Tick& tick : ticks)
        for (const Change& change : tick.changes) {
            const std::string why = cause(change);
            out += fmt::format("tick {:<6} {}{}{}{}\n", tick.tick, change.came ? '+' : '-', change.fact, why.empty() ? "" : "  ", why);
        }
    return out.empty() ? fmt::format("no fact from tick {} to tick {}\n", first_tick, last_tick) : out;
}

Json Comings::to_json() const {
    Json list = Json::array();
    for (const Tick& tick : ticks) {
        Json came = Json::array(), went = Json::array(), changes = Json::array();
        for (const Change& change : tick.changes) {
            (change.came ? came : went).push_back(change.fact);
            Json rules = Json::array();
            for (const Way& way : change.rules) {
                Json rule = {{"rule", way.rule}, {"text", way.text}, {"file", way.file}, {"line", way.line}};
                if (way.catom) rule["catom"] = *way.catom;
                rules.push_back(std::move(rule));
            }
            Json one = {{"fact", change.fact}, {"is", change.came ? "came" : "went"}, {"how", name_of(change.how)}};
            if (!change.by.empty()) one["by"] = change.by;
            one["rules"] = std::move(rules);
            if (change.more > 0) one["more"] = change.more;
            changes.push_back(std::move(one));
        }
        list.push_back({{"tick", tick.tick}, {"came", std::move(came)}, {"went", std::move(went)}, {"changes", std::move(changes)}});
    }
    return {{"history", asked}, {"first_tick", first_tick}, {"tick", last_tick}, {"at_first", at_first}, {"ticks", std::move(list)}};
}

}  // namespace meld::inspect
