#include "runtime/driver/shrink/failure.h"

#include <cctype>
#include <string_view>

#include "runtime/sim/ending_name.h"

namespace meld::driver {

namespace {

constexpr int kSignals = 128;  // Exit codes above this one stand for signals, as shells count.
constexpr std::string_view kTimeLimit = "the time limit of ";

bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

// A number that belongs to the program: rule p@12, program.meld:12:5.
bool of_the_program(const std::string& text, std::size_t at) {
    if (at >= 2 && text[at - 1] == '@') {
        const char before = text[at - 2];
        return std::isalnum(static_cast<unsigned char>(before)) != 0 || before == '_' || before == '\'';
    }
    std::size_t begin = at;
    while (begin > 0 && (is_digit(text[begin - 1]) || text[begin - 1] == ':')) --begin;
    return std::string_view(text).substr(0, begin).ends_with(".meld");
}

}  // namespace

std::string without_numbers(const std::string& text, const std::string& world_path) {
    std::string plain = text;
    if (!world_path.empty())
        for (std::size_t at = 0; (at = plain.find(world_path, at)) != std::string::npos;) plain.replace(at, world_path.size(), "WORLD");
    std::string out;
    for (std::size_t at = 0, end = 0; at < plain.size(); at = end) {
        end = at;
        while (end < plain.size() && is_digit(plain[end])) ++end;
        if (end == at) {
            out += plain[end++];
        } else if (of_the_program(plain, at)) {
            out.append(plain, at, end - at);
        } else {
            // A sign belongs to the number.
            if (out.ends_with('-') && (out.size() == 1 || std::string_view(" (,").find(out[out.size() - 2]) != std::string_view::npos))
                out.pop_back();
            out += '#';
        }
    }
    return out;
}

std::optional<Failure> failure_in(const RowResult& result, const Study& study, const std::string& world_path) {
    Failure failure{.exit = result.exit, .ended = result.ended, .ticks = result.counts.value("ticks", std::int64_t{0})};
    if (!result.fine) {
        failure.kind = result.exit > kSignals                  ? Failure::Kind::Signal
                       : result.reason.starts_with(kTimeLimit) ? Failure::Kind::TimeLimit
                                                               : Failure::Kind::Error;
        if (failure.kind == Failure::Kind::Error) failure.what = without_numbers(result.reason, world_path);
        return failure;
    }
    for (const StudyDemand& demand : study.demands) {
        if (result.demands.value(demand_key(demand), "").empty()) continue;
        failure.kind = demand.never ? Failure::Kind::Never : Failure::Kind::Expect;
        failure.what = demand_key(demand);
        return failure;
    }
    for (const auto& [key, value] : result.measures.items()) {
        if (!value.is_object()) continue;
        failure.kind = Failure::Kind::Measure;
        failure.what = key;
        return failure;
    }
    return std::nullopt;
}

bool same_failure(const Failure& failure, const Failure& other) {
    if (failure.kind != other.kind || failure.exit != other.exit || failure.what != other.what) return false;
    if (failure.kind != Failure::Kind::Expect || failure.ended == other.ended) return true;
    return failure.ended == sim::name_of(sim::Ending::Ticks) && other.ended == sim::name_of(sim::Ending::Quiet);
}

}  // namespace meld::driver
