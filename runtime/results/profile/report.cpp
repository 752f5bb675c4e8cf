#include "runtime/results/profile/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "runtime/base/shallow_json.h"
#include "runtime/base/units.h"
#include "runtime/results/profile/rule_text.h"
#include "runtime/results/profile/table.h"

namespace meld::profile {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kShown = 10;

Json link_json(const LinkCounts& link) { return {{"messages", link.messages}, {"bits", link.bits}}; }

// A rule's messages: the linear facts that it sends, and the changed facts of neighbours that it reads.
LinkCounts messages_of(const ModuleInfo& module, const Gathered& all, u32 rule) {
    LinkCounts sum{all.rules[rule].messages, all.rules[rule].bits};
    for (u32 i = 0; i < module.rules[rule].reads_there_count; ++i) {
        const PredicateCounts& read = all.predicates[module.rules[rule].reads_there[i]].counts;
        sum.messages += read.messages;
        sum.bits += read.bits;
    }
    return sum;
}

Json rules_json(const ModuleInfo& module, const Gathered& all) {
    Json rules = Json::array();
    for (u32 r = 0; r < module.rule_count; ++r) {
        const RuleInfo& info = module.rules[r];
        Json rule = {{"rule", info.name}, {"text", info.text}, {"file", info.file}, {"line", info.line}};
        if (all.rules_counted) {
            const RuleCounts& counts = all.rules[r];
            const LinkCounts messages = messages_of(module, all, r);
            rule.update({{"evaluations", counts.evaluations},
                         {"firings", counts.firings},
                         {"derivations", counts.derivations},
                         {"messages", messages.messages},
                         {"bits", messages.bits},
                         {"sent_messages", counts.messages},
                         {"sent_bits", counts.bits}});
        }
        rules.push_back(std::move(rule));
    }
    return rules;
}

Json predicates_json(const ModuleInfo& module, const Gathered& all) {
    Json predicates = Json::array();
    for (u32 i = 0; i < module.predicate_count; ++i) {
        const PredicateInfo& info = module.predicates[i];
        const PredicateLoad& load = all.predicates[i];
        const PredicateCounts& counts = load.counts;
        // The prelude's that the program does not use.
        if (info.column == kNone16 && counts.last_tick == 0) continue;
        Json one = {{"predicate", fmt::format("{}/{}", info.name, info.arity + 1)},
                    {"number", i},
                    {"made_by_compiler", info.auxiliary},
                    {"facts", load.facts},
                    {"bytes", load.bytes}};
        if (all.rules_counted) {
            one["gained"] = counts.gained;
            one["lost"] = counts.lost;
            one["retracted"] = counts.retracted;
            one["quarantined"] = counts.waiting;
            one["messages"] = counts.messages;
            one["bits"] = counts.bits;
            one["last_active_tick"] = counts.last_tick;
        }
        predicates.push_back(std::move(one));
    }
    return predicates;
}

Json catom_json(const Gathered& all, const NamedCatom& catom) {
    Json one = {{"catom", catom.id}, {"evaluations", catom.load.evaluations}};
    if (!all.rules_counted) return one;
    one["messages"] = catom.load.messages().messages;
    one["bits"] = catom.load.messages().bits;
    one["busiest_link"] = link_json(catom.load.greatest_link());
    return one;
}

// What a paper on a distributed algorithm would tell of the run.
Json algorithm_json(const Gathered& all) {
    Json rounds = Json::array();
    for (const Settling& s : all.settlings)
        rounds.push_back({{"from", s.cause == Settling::Cause::Start     ? "start"
                                   : s.cause == Settling::Cause::Resumed ? "resumed"
                                                                         : "event"},
                          {"tick", s.tick},
                          {"rounds", s.rounds ? Json(*s.rounds) : Json()}});
    Json json = {{"settling", rounds}, {"settling_left_out", all.settlings_left_out}};
    if (!all.rules_counted) return json;
    PredicateCounts sum;
    for (const PredicateLoad& p : all.predicates) eval::add(sum, p.counts);
    std::uint64_t catoms = 0;
    for (const ProcessLoad& p : all.processes) catoms += p.catoms;
    json["messages"] = sum.messages;
    json["bits"] = sum.bits;
    json["messages_per_catom"] = catoms == 0 ? 0 : static_cast<double>(sum.messages) / static_cast<double>(catoms);
    json["bits_per_catom"] = catoms == 0 ? 0 : static_cast<double>(sum.bits) / static_cast<double>(catoms);
    if (!all.most_messages.empty()) json["busiest_catom"] = catom_json(all, all.most_messages.front());
    if (all.busiest_link) {
        json["busiest_link"] = link_json(all.busiest_link->load.greatest_link());
        json["busiest_link"]["catom"] = all.busiest_link->id;
    }
    json["link_in_one_tick"] = link_json(all.in_one_tick);
    json["retractions"] = sum.retracted;
    json["quarantined"] = sum.waiting;
    return json;
}

}  // namespace

Json to_json(const ModuleInfo& module, const Gathered& all) {
    Json busiest = Json::array(), talkers = Json::array(), processes = Json::array(), ticks = Json::array();
    for (const NamedCatom& catom : all.busiest) busiest.push_back(catom_json(all, catom));
    for (const NamedCatom& catom : all.most_messages)
        if (catom.load.messages().messages > 0) talkers.push_back(catom_json(all, catom));
    for (std::size_t i = 0; i < all.processes.size(); ++i) {
        const ProcessLoad& p = all.processes[i];
        processes.push_back({{"process", i},
                             {"catoms", p.catoms},
                             {"evaluations", p.evaluations},
                             {"derivations", p.derivations},
                             {"exported_changes", p.changes},
                             {"linear_messages", p.messages},
                             {"bytes", p.bytes}});
    }
    for (const TickLoad& t : all.ticks)
        ticks.push_back({{"tick", t.tick},
                         {"evaluations", t.evaluations},
                         {"derivations", t.derivations},
                         {"exported_changes", t.changes},
                         {"linear_messages", t.messages}});
    Json json = {{"first_tick", all.first_tick}, {"last_tick", all.last_tick}, {"algorithm", algorithm_json(all)}};
    json["rules"] = rules_json(module, all);
    json["predicates"] = predicates_json(module, all);
    json["busiest_catoms"] = busiest;
    if (all.rules_counted) json["catoms_with_most_messages"] = talkers;
    json["processes"] = processes;
    json["busiest_ticks"] = ticks;
    return json;
}

namespace {

std::string number(const Json& json, const char* key) { return grouped(whole_number<std::uint64_t>(json.at(key))); }

std::vector<std::string> numbers(const Json& json, std::initializer_list<const char*> keys) {
    std::vector<std::string> cells;
    for (const char* key : keys) cells.push_back(number(json, key));
    return cells;
}

std::string settling_text(const Json& settling, std::uint64_t left_out) {
    std::string text;
    std::size_t shown = 0;
    for (const Json& s : settling) {
        if (shown++ == kShown) return text + fmt::format(", and {} more", grouped(settling.size() - kShown + left_out));
        const std::string from = s.at("from").get<std::string>();
        const std::string what = from == "event"   ? fmt::format("the event in tick {}", whole_number<std::int64_t>(s.at("tick")))
                                 : from == "start" ? std::string("the start")
                                                   : fmt::format("tick {}", whole_number<std::int64_t>(s.at("tick")));
        const std::string rounds = s.at("rounds").is_null() ? "not quiet" : number(s, "rounds");
        text += fmt::format("{}{} from {}", text.empty() ? "" : ", ", rounds, what);
    }
    return text;
}

std::string algorithm_text(const Json& a) {
    std::string text = "algorithm\n";
    const auto row = [&](const char* name, const std::string& value) { text += fmt::format("  {:<18}{}\n", name, value); };
    row("rounds", settling_text(a.at("settling"), whole_number<std::uint64_t>(a.at("settling_left_out"))));
    if (!a.contains("messages")) return text;
    row("messages", fmt::format("{} of {} bits; {:.1f} of {:.0f} bits a catom", number(a, "messages"), number(a, "bits"),
                                a.at("messages_per_catom").get<double>(), a.at("bits_per_catom").get<double>()));
    if (a.contains("busiest_catom") && a.at("messages") != 0) {
        const Json& catom = a.at("busiest_catom");
        row("busiest catom", fmt::format("@{}: {} of {} bits", whole_number<std::uint64_t>(catom.at("catom")), number(catom, "messages"),
                                         number(catom, "bits")));
        const Json& link = a.at("busiest_link");
        row("busiest link", fmt::format("out of @{}: {} of {} bits; at most {} of {} bits in one tick, over any link",
                                        whole_number<std::uint64_t>(link.at("catom")), number(link, "messages"), number(link, "bits"),
                                        number(a.at("link_in_one_tick"), "messages"), number(a.at("link_in_one_tick"), "bits")));
    }
    row("retractions", number(a, "retractions"));
    row("quarantined", number(a, "quarantined"));
    return text;
}

std::string section(const std::string& title, const Table& table) { return table.empty() ? "" : title + "\n" + table.text(); }

std::string of_all(const char* what, std::size_t all) {
    return all > kShown ? fmt::format("{}, the {} busiest of {}", what, kShown, grouped(all)) : std::string(what);
}

std::string rules_text(const Json& rules) {
    std::vector<const Json*> order;
    for (const Json& rule : rules) order.push_back(&rule);
    const auto load = [](const Json& rule) {
        return whole_number<std::uint64_t>(rule.at("evaluations")) + whole_number<std::uint64_t>(rule.at("derivations"));
    };
    std::stable_sort(order.begin(), order.end(), [&](const Json* a, const Json* b) { return load(*a) > load(*b); });
    Table table({"evaluations", "firings", "derivations", "messages", "bits", "rule"});
    for (std::size_t i = 0; i < std::min(kShown, order.size()); ++i) {
        auto cells = numbers(*order[i], {"evaluations", "firings", "derivations", "messages", "bits"});
        cells.push_back(rule_text(*order[i]));
        table.add(std::move(cells));
    }
    return section(of_all("rules", rules.size()), table);
}

std::string predicates_text(const Json& predicates, bool counted) {
    std::vector<std::string> heads = {"facts", "bytes"};
    if (counted) heads.insert(heads.end(), {"gained", "lost", "retracted", "quarantined", "messages", "bits", "last tick"});
    heads.emplace_back("predicate");
    Table table(heads);
    for (const Json& p : predicates) {
        auto cells = numbers(p, {"facts", "bytes"});
        if (counted)
            for (auto& cell : numbers(p, {"gained", "lost", "retracted", "quarantined", "messages", "bits", "last_active_tick"}))
                cells.push_back(std::move(cell));
        cells.push_back(p.at("predicate").get<std::string>() + (p.at("made_by_compiler").get<bool>() ? "  (made by the compiler)" : ""));
        table.add(std::move(cells));
    }
    return section("predicates", table);
}

std::string catoms_text(const std::string& title, const Json& catoms, bool counted) {
    std::vector<std::string> heads = {"evaluations"};
    if (counted) heads.insert(heads.end(), {"messages", "bits", "busiest link"});
    heads.emplace_back("catom");
    Table table(heads);
    for (const Json& c : catoms) {
        auto cells = numbers(c, {"evaluations"});
        if (counted) {
            for (auto& cell : numbers(c, {"messages", "bits"})) cells.push_back(std::move(cell));
            cells.push_back(number(c.at("busiest_link"), "messages"));
        }
        cells.push_back(fmt::format("@{}", whole_number<std::uint64_t>(c.at("catom"))));
        table.add(std::move(cells));
    }
    return section(title, table);
}

}  // namespace

std::string tables(const Json& s) {
    const bool counted = s.at("algorithm").contains("messages");
    std::string text = algorithm_text(s.at("algorithm"));
    if (counted) text += rules_text(s.at("rules"));
    text += predicates_text(s.at("predicates"), counted);
    text += catoms_text("catoms with most evaluations", s.at("busiest_catoms"), counted);
    if (counted) text += catoms_text("catoms with most messages", s.at("catoms_with_most_messages"), counted);
    const std::initializer_list<const char*> work = {"evaluations", "derivations", "exported_changes", "linear_messages"};
    Table ticks({"evaluations", "derivations", "exported changes", "linear messages", "tick"});
    for (const Json& t : s.at("busiest_ticks")) {
        auto cells = numbers(t, work);
        cells.push_back(number(t, "tick"));
        ticks.add(std::move(cells));
    }
    text += section("busiest ticks", ticks);
    if (s.at("processes").size() == 1) return text;
    Table processes({"catoms", "memory", "evaluations", "derivations", "exported changes", "linear messages", "process"});
    for (const Json& p : s.at("processes")) {
        auto cells = numbers(p, work);
        cells.insert(cells.begin(), {number(p, "catoms"), format_bytes(whole_number<std::uint64_t>(p.at("bytes")))});
        cells.push_back(number(p, "process"));
        processes.add(std::move(cells));
    }
    return text + section("processes", processes);
}

}  // namespace meld::profile
