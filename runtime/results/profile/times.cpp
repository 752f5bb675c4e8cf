#include "runtime/results/profile/times.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numeric>
#include <utility>
#include <vector>

#include "runtime/base/bytes.h"
#include "runtime/base/shallow_json.h"
#include "runtime/base/units.h"
#include "runtime/comm/transport/gather_to_root.h"
#include "runtime/results/profile/rule_text.h"
#include "runtime/results/profile/table.h"

namespace meld::profile {

namespace {

using Json = nlohmann::ordered_json;
using Stage = TickLog::Stage;

// What one process has measured.
struct Times {
    eval::CpuSeconds cpu;
    std::vector<TickLog::Span> spans;
};

std::vector<std::byte> pack(const TickLog& log, const eval::CpuSeconds& cpu) {
    ByteWriter out;
    for (const auto* list : {&cpu.rules, &cpu.predicates}) {
        out.write_count(list->size());
        for (const double seconds : *list) out.write(seconds);
    }
    out.write(cpu.other);
    out.write(cpu.samples);
    out.write_count(log.spans().size());
    for (const TickLog::Span& span : log.spans()) {
        out.write(span.first);
        out.write(span.last);
        out.write(span.begin);
        for (const double seconds : span.seconds) out.write(seconds);
        out.write_count(span.busy.size());
        for (const double seconds : span.busy) out.write(seconds);
    }
    return out.take();
}

Times unpack(const std::vector<std::byte>& bytes) {
    ByteReader in(bytes, "the times of a process");
    Times out;
    const auto numbers = [&] {
        std::vector<double> all(in.read_count(sizeof(double)));
        for (double& one : all) one = in.read<double>();
        return all;
    };
    out.cpu.rules = numbers();
    out.cpu.predicates = numbers();
    out.cpu.other = in.read<double>();
    out.cpu.samples = in.read<u64>();
    out.spans.resize(in.read_count(sizeof(double)));
    for (TickLog::Span& span : out.spans) {
        span.first = in.read<std::int64_t>();
        span.last = in.read<std::int64_t>();
        span.begin = in.read<double>();
        for (double& seconds : span.seconds) seconds = in.read<double>();
        span.busy = numbers();
    }
    return out;
}

// To whole microseconds: more digits say nothing.
double rounded(double seconds) { return static_cast<double>(static_cast<std::int64_t>(seconds * 1e6 + 0.5)) * 1e-6; }

Json rounded(const auto& all) {
    Json out = Json::array();
    for (const double seconds : all) out.push_back(rounded(seconds));
    return out;
}

Json process_json(const Times& times) {
    std::array<double, TickLog::kStages> stages{};
    std::vector<double> busy;
    Json spans = Json::array();
    for (const TickLog::Span& span : times.spans) {
        for (std::size_t i = 0; i < stages.size(); ++i) stages[i] += span.seconds[i];
        busy.resize(std::max(busy.size(), span.busy.size()), 0.0);
        for (std::size_t i = 0; i < span.busy.size(); ++i) busy[i] += span.busy[i];
        spans.push_back({span.first, span.last, rounded(span.begin), rounded(span.seconds), rounded(span.busy)});
    }
    Json named = Json::object();
    for (std::size_t i = 0; i < stages.size(); ++i) named[TickLog::name(static_cast<Stage>(i))] = rounded(stages[i]);
    return {{"wall_seconds", named}, {"busy_seconds_of_threads", rounded(busy)}, {"spans", spans}};
}

}  // namespace

void add_times(const sim::Subdomain& subdomain, const TickLog& log, const eval::CpuSeconds& cpu, Json& statistics) {
    const ModuleInfo& module = subdomain.module;
    const std::vector<std::vector<std::byte>> all = comm::gather_to_root(subdomain.comm, pack(log, cpu));
    if (subdomain.comm.process() != 0) return;

    std::vector<double> rules(module.rule_count, 0.0), predicates(module.predicate_count, 0.0);
    double other = 0;
    u64 samples = 0;
    Json& processes = statistics.at("processes");
    for (std::size_t i = 0; i < all.size(); ++i) {
        const Times times = unpack(all[i]);
        for (std::size_t r = 0; r < rules.size(); ++r) rules[r] += times.cpu.rules[r];
        for (std::size_t p = 0; p < predicates.size(); ++p) predicates[p] += times.cpu.predicates[p];
        other += times.cpu.other;
        samples += times.cpu.samples;
        processes[i].update(process_json(times));
    }
    for (std::size_t r = 0; r < rules.size(); ++r) statistics.at("rules")[r]["cpu_seconds"] = rounded(rules[r]);
    // Predicates that are not used are left out there.
    for (Json& p : statistics.at("predicates")) p["cpu_seconds"] = rounded(predicates.at(p.at("number").get<std::size_t>()));
    statistics["other_cpu_seconds"] = rounded(other);
    statistics["cpu_samples"] = samples;
}

namespace {

constexpr std::size_t kRowsShown = 20;

std::string percent(double part, double whole) { return whole > 0 ? fmt::format("{:.1f} %", 100 * part / whole) : "-"; }

double sum_of(const Json& list, const char* key) {
    double sum = 0;
    for (const Json& one : list) sum += one.at(key).get<double>();
    return sum;
}

// Those that took any time, the greatest first.
std::vector<const Json*> by_time(const Json& list) {
    std::vector<const Json*> order;
    for (const Json& one : list)
        if (one.at("cpu_seconds").get<double>() > 0) order.push_back(&one);
    std::stable_sort(order.begin(), order.end(),
                     [](const Json* a, const Json* b) { return a->at("cpu_seconds").get<double>() > b->at("cpu_seconds").get<double>(); });
    return order;
}

}  // namespace

std::string time_tables(const Json& profile) {
    const double bodies = sum_of(profile.at("rules"), "cpu_seconds"), deciding = sum_of(profile.at("predicates"), "cpu_seconds");
    const double other = profile.at("other_cpu_seconds").get<double>(), all = bodies + deciding + other;
    const auto samples = whole_number<std::uint64_t>(profile.at("cpu_samples"));
    std::string text = fmt::format(
        "CPU time of evaluation: {}, by {} sample{}; {} in bodies of rules, {} in deciding what holds, {} in reading and writing catoms\n",
        format_duration(all), grouped(samples), samples == 1 ? "" : "s", percent(bodies, all), percent(deciding, all), percent(other, all));
    std::vector<std::string> columns = {"share", "CPU time"};
    const bool counted = profile.at("algorithm").contains("messages");
    if (counted) columns.insert(columns.end(), {"evaluations", "derivations"});
    columns.emplace_back("rule");
    Table rules(columns);
    for (const Json* rule : by_time(profile.at("rules"))) {
        const double seconds = rule->at("cpu_seconds").get<double>();
        std::vector<std::string> cells = {percent(seconds, all), format_duration(seconds)};
        if (counted)
            for (const char* count : {"evaluations", "derivations"}) cells.push_back(grouped(whole_number<std::uint64_t>(rule->at(count))));
        cells.push_back(rule_text(*rule));
        rules.add(std::move(cells));
        if (rules.size() == kRowsShown) break;
    }
    if (!rules.empty()) text += "hottest rules\n" + rules.text();
    Table decided({"share", "CPU time", "predicate"});
    for (const Json* p : by_time(profile.at("predicates"))) {
        const double seconds = p->at("cpu_seconds").get<double>();
        decided.add({percent(seconds, all), format_duration(seconds), p->at("predicate").get<std::string>()});
        if (decided.size() == kRowsShown) break;
    }
    if (!decided.empty()) text += "deciding what holds\n" + decided.text();
    std::vector<std::string> heads;
    for (std::size_t i = 0; i < TickLog::kStages; ++i) heads.emplace_back(TickLog::name(static_cast<Stage>(i)));
    heads.insert(heads.end(), {"threads busy", "process"});
    Table stages(heads);
    for (const Json& process : profile.at("processes")) {
        std::vector<std::string> cells;
        for (std::size_t i = 0; i < TickLog::kStages; ++i)
            cells.push_back(format_duration(process.at("wall_seconds").at(TickLog::name(static_cast<Stage>(i))).get<double>()));
        std::string busy;
        for (const Json& seconds : process.at("busy_seconds_of_threads"))
            busy += (busy.empty() ? "" : " ") + percent(seconds.get<double>(), process.at("wall_seconds").at("evaluation").get<double>());
        cells.push_back(busy);
        cells.push_back(std::to_string(whole_number<int>(process.at("process"))));
        stages.add(std::move(cells));
    }
    return text + "wall-clock time by stages of the tick\n" + stages.text();
}

std::string trace_events(const Json& profile) {
    // Microseconds, as the format has them.
    const auto micros = [](double seconds) { return seconds * 1e6; };
    std::string text = "{\"traceEvents\":[\n";
    const auto event = [&](const std::string& name, std::size_t process, std::size_t thread, double begin, double seconds) {
        text += fmt::format("{{\"name\":{},\"ph\":\"X\",\"pid\":{},\"tid\":{},\"ts\":{:.3f},\"dur\":{:.3f}}},\n", Json(name).dump(),
                            process, thread, micros(begin), micros(seconds));
    };
    const auto name_it = [&](const char* what, std::size_t process, std::size_t thread, const std::string& name) {
        text += fmt::format("{{\"name\":\"{}\",\"ph\":\"M\",\"pid\":{},\"tid\":{},\"args\":{{\"name\":{}}}}},\n", what, process, thread,
                            Json(name).dump());
    };
    for (const Json& process : profile.at("processes")) {
        const auto pid = whole_number<std::size_t>(process.at("process"));
        name_it("process_name", pid, 0, fmt::format("process {}", pid));
        name_it("thread_name", pid, 0, "ticks");
        for (std::size_t i = 0; i < process.at("busy_seconds_of_threads").size(); ++i)
            name_it("thread_name", pid, i + 1, fmt::format("thread {}", i));
        for (const Json& span : process.at("spans")) {
            const auto first = whole_number<std::int64_t>(span.at(0)), last = whole_number<std::int64_t>(span.at(1));
            const double begin = span.at(2).get<double>();
            const auto seconds = span.at(3).get<std::array<double, TickLog::kStages>>();
            // What is between ticks is no part of one.
            const double within = std::accumulate(seconds.begin(), seconds.end() - 1, 0.0);
            event(first == last ? fmt::format("tick {}", first) : fmt::format("ticks {} to {}", first, last), pid, 0, begin, within);
            double at = begin;
            for (std::size_t i = 0; i + 1 < seconds.size(); ++i) {
                if (seconds[i] > 0) event(TickLog::name(static_cast<Stage>(i)), pid, 0, at, seconds[i]);
                if (static_cast<Stage>(i) == Stage::Evaluation) {
                    std::size_t thread = 1;
                    for (const Json& busy : span.at(4)) {
                        if (busy.get<double>() > 0) event("evaluation", pid, thread, at, busy.get<double>());
                        ++thread;
                    }
                }
                at += seconds[i];
            }
        }
    }
    if (text.ends_with(",\n")) text.erase(text.size() - 2);
    return text + "\n],\"displayTimeUnit\":\"ms\"}\n";
}

}  // namespace meld::profile
