// Messages for people, for programs, for tables and for Graphviz.
#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "runtime/ask/messages/messages.h"
#include "runtime/base/csv_row.h"

namespace meld::inspect {

namespace {

using Json = nlohmann::ordered_json;
using One = Messages::One;

const char* name_of(One::Is is) {
    switch (is) {
        case One::Is::Came:
            return "came";
        case One::Is::Went:
            return "went";
        case One::Is::Changed:
            return "changed";
        case One::Is::Ranked:
            return "ranked";
        case One::Is::Sent:
            return "sent";
        case One::Is::Module:
            return "module";
    }
    return "";
}

// +dist(@4, 1): as `history` writes what comes and goes.
std::string what(const One& one) {
    switch (one.is) {
        case One::Is::Came:
            return "+" + one.fact;
        case One::Is::Went:
            return "-" + one.fact;
        case One::Is::Changed:
            return fmt::format("+{}  instead of {}", one.fact, one.was);
        case One::Is::Ranked:
            return fmt::format("{}  with another rank, {}", one.fact, one.rank);
        case One::Is::Sent:
            return one.due ? fmt::format("{}  for tick {}", one.fact, *one.due) : one.fact;
        case One::Is::Module:
            return one.fact + "  by a module";
    }
    return "";
}

std::string plural(u64 count, const char* noun) { return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s"); }

}  // namespace

std::string Messages::to_text() const {
    std::string out = fmt::format("tick {}: {}", tick, plural(count, "message"));
    if (catom) out += fmt::format(" over the links of @{}: {} in, {} out", *catom, incoming, outgoing);
    out += "\n";
    for (const One& one : shown) out += fmt::format("@{} -> @{}  {}\n", one.from, one.to, what(one));
    if (shown.size() < count) out += fmt::format("... and {} more\n", count - shown.size());
    for (const Waiting& one : waiting) out += fmt::format("{} waits for tick {}\n", one.fact, one.tick);
    if (waiting.size() < waiting_count) out += fmt::format("... and {} more that wait\n", waiting_count - waiting.size());
    return out;
}

Json Messages::to_json() const {
    Json list = Json::array(), waits = Json::array(), counted = Json::array();
    for (const Predicate& p : predicates)
        counted.push_back({{"predicate", p.name}, {"number", p.number}, {"made_by_compiler", p.auxiliary}, {"messages", p.count}});
    for (const One& one : shown) {
        Json message = {{"from", one.from}, {"to", one.to}, {"is", name_of(one.is)}, {"fact", one.fact}};
        if (!one.was.empty()) message["was"] = one.was;
        if (one.rank != kAbsent) message["rank"] = one.rank;
        message["read"] = tick + 1;
        if (one.due) message["due"] = *one.due;
        list.push_back(std::move(message));
    }
    for (const Waiting& one : waiting) waits.push_back({{"catom", one.catom}, {"fact", one.fact}, {"due", one.tick}});
    Json json = {{"tick", tick}, {"catom", catom ? Json(*catom) : Json()}, {"count", count}};
    if (catom) {
        json["in"] = incoming;
        json["out"] = outgoing;
    }
    json["by_modules"] = modules;
    json["predicates"] = std::move(counted);
    json["messages"] = std::move(list);
    json["waiting_count"] = waiting_count;
    json["waiting"] = std::move(waits);
    return json;
}

std::string Messages::to_csv() const {
    std::string out = "from,to,is,fact,was,rank,read,due\n";
    for (const One& one : shown)
        out += fmt::format("{},{},{},{},{},{},{},{}\n", one.from, one.to, name_of(one.is), csv_field(one.fact), csv_field(one.was),
                           one.rank == kAbsent ? "" : std::to_string(one.rank), tick + 1, one.due ? std::to_string(*one.due) : "");
    return out;
}

std::string Messages::to_dot() const {
    std::map<std::pair<u64, u64>, std::string> links;
    for (const One& one : shown) {
        std::string& label = links[{one.from, one.to}];
        if (!label.empty()) label += "\\n";
        for (const char c : what(one)) {
            if (c == '"' || c == '\\') label += '\\';
            label += c;
        }
    }
    std::string out = "digraph messages {\n";
    for (const auto& [link, label] : links) out += fmt::format("  \"@{}\" -> \"@{}\" [label=\"{}\"];\n", link.first, link.second, label);
    return out + "}\n";
}

}  // namespace meld::inspect
