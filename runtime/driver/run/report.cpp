#include "runtime/driver/run/report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "runtime/base/terminal/terminal_text.h"
#include "runtime/base/units.h"
#include "runtime/module/abi/actions.h"
#include "runtime/sim/ending_name.h"

namespace meld::driver {

namespace {

const char* ending_text(sim::Ending ending) {
    switch (ending) {
        case sim::Ending::Quiet:
            return "nothing left to do";
        case sim::Ending::Ticks:
            return "as many ticks as asked for";
        case sim::Ending::Finished:
            return "stopped by the program";
        case sim::Ending::Watched:
            return "stopped by a watch";
        case sim::Ending::Interrupted:
            return "interrupted";
        case sim::Ending::Failed:
            return "the program failed";
    }
    return "";
}

std::string peak_text(const MemoryReport& memory, int processes) {
    if (memory.peak == 0) return "";
    return fmt::format("; {}{} at the peak", format_bytes(memory.peak), processes > 1 ? " in a process" : "");
}

// With the name of what forbids it, if there is one.
std::string why_refused(sim::Refusal why, const About& about) {
    if (why == sim::Refusal::NotAllowed && !about.moves.empty()) return "not allowed by " + about.moves;
    return std::string(text_of(why));
}

std::string world_text(const About& about) {
    if (about.default_world) return about.world;
    return fmt::format("{}, {} catom{}", about.world, grouped(about.world_catoms), about.world_catoms == 1 ? "" : "s");
}

// Of what was not carried out because the world has no motion, or another one; empty: nothing.
std::string warning_of_other_worlds(const sim::Summary& s) {
    std::uint64_t all = 0;
    // The kind of motion that carries out the first of them.
    std::string_view kind;
    for (const sim::Refused& each : s.refused) {
        if (each.why != sim::Refusal::NotInThisWorld) continue;
        all += each.count;
        const ActionInfo::Performer performer = info(each.action).performer;
        if (kind.empty())
            kind = performer == ActionInfo::Performer::Lattice    ? "lattice"
                   : performer == ActionInfo::Performer::Amoebots ? "amoebot"
                   : performer == ActionInfo::Performer::Points   ? "points"
                                                                  : "bodies";
    }
    if (all == 0) return "";
    return fmt::format("{} action{} not carried out, since nothing in this world does so: give it [motion] kind = \"{}\"", grouped(all),
                       all == 1 ? " was" : "s were", kind);
}

std::string warning_of_dropped(const sim::Summary& s, const world::World& world) {
    // A program for a raw network expects it.
    if (s.dropped == 0 || world.network.kind == world::NetworkKind::Raw) return "";
    return fmt::format(
        "{} linear fact{} dropped, since the catom {} for {}. Declare `type linear undelivered-p(node, node To, "
        "...)` for the predicate p that is sent, and they come back",
        grouped(s.dropped), s.dropped == 1 ? " was" : "s were", s.dropped == 1 ? "it was" : "they were",
        s.far_facts > 0 ? "is not there, or out of reach" : "was no longer a neighbour");
}

nlohmann::ordered_json to_json(const std::vector<sim::Refused>& refused) {
    nlohmann::ordered_json all = nlohmann::ordered_json::array();
    for (const sim::Refused& each : refused)
        all.push_back({{"action", info(each.action).word}, {"reason", name_of(each.why)}, {"count", each.count}});
    return all;
}

nlohmann::ordered_json to_json(const Forked& forked) {
    return {{"folder", forked.folder},
            {"tick", forked.tick},
            {"digest", forked.digest},
            {"changed", forked.changed},
            {"anew", forked.anew},
            {"taken_over", forked.facts.taken_over},
            {"dropped", forked.facts.dropped},
            {"derived_anew", forked.facts.derived_anew}};
}

}  // namespace

Pace::Counts::Counts(const sim::Summary& summary, double at_seconds)
    : ticks(summary.ticks), derivations(summary.derivations), messages(summary.changes + summary.messages), seconds(at_seconds) {}

Pace::Rates Pace::rates(const sim::Summary& summary, double seconds) {
    const Counts now(summary, seconds);
    if (now.ticks < since_.ticks) since_ = now;
    if (now.seconds <= since_.seconds) return {};
    const double rate = 1 / (now.seconds - since_.seconds);
    return {rate * static_cast<double>(now.ticks - since_.ticks), rate * static_cast<double>(now.derivations - since_.derivations),
            rate * static_cast<double>(now.messages - since_.messages)};
}

std::string progress_line(const sim::Simulation& simulation, Pace& pace, std::int64_t last_tick) {
    auto& s = const_cast<sim::Simulation&>(simulation).summary();
    const auto& totals = const_cast<sim::Simulation&>(simulation).subdomain().totals;
    const Pace::Rates rates = pace.rates(s);
    std::string text = fmt::format("tick {}{}, {} awake of {}, {} derivations/s, {} messages/s, {:.0f} bytes a catom", s.ticks,
                                   last_tick > 0 ? fmt::format(" of {}", last_tick) : "",
                                   format_count(static_cast<double>(totals.tick.awake)), format_count(static_cast<double>(s.catoms)),
                                   format_count(rates.derivations), format_count(rates.messages), s.bytes_per_catom);
    if (last_tick > 0 && rates.ticks > 0) text += ", " + format_duration(static_cast<double>(last_tick - s.ticks) / rates.ticks) + " left";
    if (const std::string status = simulation.status(); !status.empty()) text += ", " + status;
    return text;
}

// Work is counted in evaluations.
std::string divisions_text(const sim::Summary& s) {
    std::uint64_t moved = 0;
    for (const partition::Division& each : s.divisions) moved += each.moved;
    return fmt::format("{} time{}, {} catoms moved; the busiest process did {:.2f} times the mean before, and {:.2f} after the last",
                       grouped(s.divisions.size()), s.divisions.size() == 1 ? "" : "s", grouped(moved), s.divisions.front().imbalance,
                       s.imbalance);
}

nlohmann::ordered_json divisions_json(const sim::Summary& s) {
    nlohmann::ordered_json all = nlohmann::ordered_json::array();
    for (const partition::Division& each : s.divisions)
        all.push_back({{"tick", each.tick}, {"moved_catoms", each.moved}, {"imbalance_before", each.imbalance}});
    return all;
}

std::string summary_table(const sim::Summary& s, const About& about) {
    std::string text;
    const auto row = [&](const char* name, const std::string& value) { text += fmt::format("  {:<18}{}\n", name, value); };
    row("world", world_text(about));
    if (!about.never_given.empty())
        row("never given", fmt::format("{}: no rule, fact or world makes any", fmt::join(about.never_given, ", ")));
    if (about.forked) row("branched off", "from " + describe(*about.forked));
    row("ended", ending_text(s.ending));
    row("ticks", grouped(static_cast<std::uint64_t>(s.ticks)));
    row("catoms", grouped(s.catoms));
    if (s.killed > 0) row("killed", fmt::format("{} catom{}, by events", grouped(s.killed), s.killed == 1 ? "" : "s"));
    if (s.hung > 0) row("hung", fmt::format("{} catom{}", grouped(s.hung), s.hung == 1 ? "" : "s"));
    if (s.restarted > 0) row("restarted", fmt::format("{} catom{}", grouped(s.restarted), s.restarted == 1 ? "" : "s"));
    if (s.lost > 0) row("lost with them", fmt::format("{} linear fact{}", grouped(s.lost), s.lost == 1 ? "" : "s"));
    if (s.links_cut > 0) row("links cut", grouped(s.links_cut));
    if (s.links_made > 0) row("links made", grouped(s.links_made));
    if (s.nodes_made > 0) row("nodes made", grouped(s.nodes_made));
    row("evaluations", grouped(s.evaluations));
    row("derivations", grouped(s.derivations));
    row("exported changes", grouped(s.changes));
    const char* const missed = s.far_facts > 0 ? "not there, or out of reach" : "not a neighbour";
    row("linear messages", grouped(s.messages) + (s.dropped > 0 ? fmt::format(" ({} dropped: {}their target was {})", grouped(s.dropped),
                                                                              about.raw ? "lost on the way, or " : "", missed)
                                                                : ""));
    if (s.far_facts > 0)
        row("facts sent far", fmt::format("{}, in {} message{}", grouped(s.far_facts), grouped(s.far_hops), s.far_hops == 1 ? "" : "s"));
    for (const sim::Refused& each : s.refused)
        row("refused", fmt::format("{} {}: {}", grouped(each.count), info(each.action).word, why_refused(each.why, about)));
    if (s.dead_routes.count > 0) row("dead routes", describe(s.dead_routes));
    if (about.processes > 1) row("between processes", format_bytes(s.sent_bytes));
    if (s.ticks > 0) row("memory", fmt::format("{:.1f} bytes a catom{}", s.bytes_per_catom, peak_text(about.memory, about.processes)));
    row("time", fmt::format("{} to set up, {} to run ({} CPU on process 0)", format_duration(s.setup_seconds),
                            format_duration(s.run_seconds), format_duration(s.cpu_seconds)));
    row("processes", fmt::format("{} of {} thread{}", about.processes, about.threads, about.threads == 1 ? "" : "s"));
    if (!s.divisions.empty()) row("divided anew", divisions_text(s));
    for (const Restart& each : about.restarts)
        row("restarted",
            fmt::format("from {}, after {} in tick {}",
                        each.from_tick > 0 ? fmt::format("tick {}", each.from_tick) : std::string("the start"), each.reason, each.in_tick));
    for (const std::string& outcome : s.outcomes) text += visible(outcome) + "\n";
    return text;
}

std::vector<std::string> warnings(const sim::Summary& s, const world::World& world) {
    std::vector<std::string> all = {warning_of_dropped(s, world), warning_of_other_worlds(s)};
    if (!s.undefined.empty()) all.push_back("the run ended before quiescence, and " + s.undefined);
    // Catoms that move may come to touch.
    if (s.dead_routes.count > 0 && world.motion.kind == "none")
        all.push_back(describe(s.dead_routes) +
                      ": nothing is read or sent along it. Link catoms that touch, or declare the predicate without `route`");
    std::erase(all, "");
    return all;
}

nlohmann::ordered_json run_json(const sim::Summary& s, const std::string& world, int processes, int threads, const std::string& program) {
    return {{"program", program},     {"world", world},     {"ended", sim::name_of(s.ending)},  {"catoms", s.catoms},
            {"processes", processes}, {"threads", threads}, {"setup_seconds", s.setup_seconds}, {"run_seconds", s.run_seconds}};
}

nlohmann::ordered_json counts_json(const sim::Summary& s) {
    return {{"ticks", s.ticks},
            {"catoms", s.catoms},
            {"killed", s.killed},
            {"hung", s.hung},
            {"restarted", s.restarted},
            {"lost_linear_facts", s.lost},
            {"links_cut", s.links_cut},
            {"links_made", s.links_made},
            {"nodes_made", s.nodes_made},
            {"evaluations", s.evaluations},
            {"derivations", s.derivations},
            {"exported_changes", s.changes},
            {"linear_messages", s.messages},
            {"dropped_messages", s.dropped},
            {"far_facts", s.far_facts},
            {"far_messages", s.far_hops}};
}

std::string summary_json(const sim::Summary& s, const About& about, const nlohmann::ordered_json& stats) {
    nlohmann::ordered_json again = nlohmann::ordered_json::array();
    for (const Restart& each : about.restarts)
        again.push_back({{"reason", each.reason}, {"in_tick", each.in_tick}, {"from_tick", each.from_tick}});
    nlohmann::ordered_json stages = nlohmann::ordered_json::object();
    for (const auto& [name, seconds] : s.stage_seconds) stages[name] = seconds;
    nlohmann::ordered_json json = {{"world", about.world},
                                   {"default_world", about.default_world},
                                   {"world_catoms", about.world_catoms},
                                   {"never_given", about.never_given},
                                   {"ended", sim::name_of(s.ending)}};
    json.update(counts_json(s));
    json.update(nlohmann::ordered_json{
        {"refused_actions", to_json(s.refused)},
        {"dead_routes", {{"count", s.dead_routes.count}, {"first", s.dead_routes.first}}},
        {"bytes_between_processes", s.sent_bytes},
        {"bytes_per_catom", s.bytes_per_catom},
        {"peak_bytes", about.memory.peak},
        {"expected_peak_bytes", {std::llround(about.memory.expected.least), std::llround(about.memory.expected.most)}},
        {"setup_seconds", s.setup_seconds},
        {"run_seconds", s.run_seconds},
        {"cpu_seconds", s.cpu_seconds},
        {"stage_seconds", stages},
        {"processes", about.processes},
        {"threads", about.threads},
        {"divisions", divisions_json(s)},
        {"imbalance", s.imbalance},
        {"restarts", again},
        {"outcomes", s.outcomes}});
    if (!about.moves.empty()) json["moves"] = about.moves;
    if (about.forked) json["forked"] = to_json(*about.forked);
    if (!stats.empty()) json["stats"] = stats;
    // Escapes text that is not visible, and everything that is not ASCII.
    return json.dump(2, ' ', true, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace meld::driver
