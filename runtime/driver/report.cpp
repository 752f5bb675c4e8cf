#include "runtime/driver/report.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "runtime/base/units.h"
#include "runtime/base/visible.h"

namespace meld::driver {

namespace {

const char* ending_name(sim::Ending ending) {
    switch (ending) {
        case sim::Ending::Quiet:
            return "quiet";
        case sim::Ending::Ticks:
            return "ticks";
        case sim::Ending::Finished:
            return "finished";
        case sim::Ending::Interrupted:
            return "interrupted";
        case sim::Ending::Failed:
            return "failed";
    }
    return "";
}

const char* ending_text(sim::Ending ending) {
    switch (ending) {
        case sim::Ending::Quiet:
            return "nothing left to do";
        case sim::Ending::Ticks:
            return "as many ticks as asked for";
        case sim::Ending::Finished:
            return "stopped by the program";
        case sim::Ending::Interrupted:
            return "interrupted";
        case sim::Ending::Failed:
            return "the program failed";
    }
    return "";
}

std::string grouped(std::uint64_t n) {
    std::string text = std::to_string(n);
    for (std::ptrdiff_t i = static_cast<std::ptrdiff_t>(text.size()) - 3; i > 0; i -= 3) text.insert(static_cast<std::size_t>(i), ",");
    return text;
}

std::string peak_text(const MemoryReport& memory, int processes) {
    if (memory.peak == 0) return "";
    return fmt::format("; {}{} at the peak", format_bytes(memory.peak), processes > 1 ? " in a process" : "");
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

std::string progress_line(const sim::Simulation& simulation, double seconds, std::int64_t last_tick) {
    auto& s = const_cast<sim::Simulation&>(simulation).summary();
    const auto& totals = const_cast<sim::Simulation&>(simulation).subdomain().totals;
    const double rate = seconds > 0 ? 1 / seconds : 0;
    std::string text =
        fmt::format("tick {}{}, {} awake of {}, {} derivations/s, {} messages/s, {:.0f} bytes a catom", s.ticks,
                    last_tick > 0 ? fmt::format(" of {}", last_tick) : "", format_count(static_cast<double>(totals.tick.awake)),
                    format_count(static_cast<double>(s.catoms)), format_count(static_cast<double>(s.derivations) * rate),
                    format_count(static_cast<double>(s.changes + s.messages) * rate), s.bytes_per_catom);
    if (last_tick > 0 && s.ticks > 0)
        text += ", " + format_duration(seconds * static_cast<double>(last_tick - s.ticks) / static_cast<double>(s.ticks)) + " left";
    if (const std::string status = simulation.status(); !status.empty()) text += ", " + status;
    return text;
}

std::string summary_table(const sim::Summary& s, const About& about) {
    std::string text;
    const auto row = [&](const char* name, const std::string& value) { text += fmt::format("  {:<18}{}\n", name, value); };
    row("world", about.world);
    if (about.forked) row("branched off", "from " + describe(*about.forked));
    row("ended", ending_text(s.ending));
    row("ticks", grouped(static_cast<std::uint64_t>(s.ticks)));
    row("catoms", grouped(s.catoms));
    row("evaluations", grouped(s.evaluations));
    row("derivations", grouped(s.derivations));
    row("exported changes", grouped(s.changes));
    row("linear messages",
        grouped(s.messages) + (s.dropped > 0 ? fmt::format(" ({} dropped: their target was not a neighbour)", grouped(s.dropped)) : ""));
    if (about.processes > 1) row("between processes", format_bytes(s.sent_bytes));
    if (s.ticks > 0) row("memory", fmt::format("{:.1f} bytes a catom{}", s.bytes_per_catom, peak_text(about.memory, about.processes)));
    row("time", fmt::format("{} to set up, {} to run ({} CPU on process 0)", format_duration(s.setup_seconds),
                            format_duration(s.run_seconds), format_duration(s.cpu_seconds)));
    row("processes", fmt::format("{} of {} thread{}", about.processes, about.threads, about.threads == 1 ? "" : "s"));
    for (const Restart& each : about.restarts)
        row("restarted",
            fmt::format("from {}, after {} in tick {}",
                        each.from_tick > 0 ? fmt::format("tick {}", each.from_tick) : std::string("the start"), each.reason, each.in_tick));
    for (const std::string& outcome : s.outcomes) text += visible(outcome) + "\n";
    return text;
}

std::string warning_of_dropped(const sim::Summary& s) {
    if (s.dropped == 0) return "";
    return fmt::format(
        "{} linear fact{} dropped, since the catom {} for was no longer a neighbour. Declare `type linear undelivered-p(node, node To, "
        "...)` for the predicate p that is sent, and they come back",
        grouped(s.dropped), s.dropped == 1 ? " was" : "s were", s.dropped == 1 ? "it was" : "they were");
}

std::string summary_json(const sim::Summary& s, const About& about) {
    nlohmann::ordered_json again = nlohmann::ordered_json::array();
    for (const Restart& each : about.restarts)
        again.push_back({{"reason", each.reason}, {"in_tick", each.in_tick}, {"from_tick", each.from_tick}});
    nlohmann::ordered_json stages = nlohmann::ordered_json::object();
    for (const auto& [name, seconds] : s.stage_seconds) stages[name] = seconds;
    nlohmann::ordered_json json = {
        {"world", about.world},
        {"ended", ending_name(s.ending)},
        {"ticks", s.ticks},
        {"catoms", s.catoms},
        {"evaluations", s.evaluations},
        {"derivations", s.derivations},
        {"exported_changes", s.changes},
        {"linear_messages", s.messages},
        {"dropped_messages", s.dropped},
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
        {"restarts", again},
        {"outcomes", s.outcomes}};
    if (about.forked) json["forked"] = to_json(*about.forked);
    // Escapes text that is not visible, and everything that is not ASCII.
    return json.dump(2, ' ', true, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace meld::driver
