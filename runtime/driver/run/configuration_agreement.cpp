#include "runtime/driver/run/configuration_agreement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>

#include "runtime/base/bytes.h"

namespace meld::driver {

namespace {

// The reply of a process: an error or its claims.
struct Statement {
    std::optional<Error> error;
    std::vector<Claim> claims;
};

std::vector<std::byte> pack(const Result<std::vector<Claim>>& mine) {
    ByteWriter out;
    out.write(mine.has_value());
    if (!mine) {
        out.write(mine.error().code);
        out.write_string(mine.error().problem);
        out.write_string(mine.error().suggestion);
        return out.take();
    }
    out.write_count(mine->size());
    for (const Claim& claim : *mine) {
        out.write(claim.hash);
        out.write(claim.code);
        out.write_string(claim.name);
        out.write_string(claim.shown);
    }
    return out.take();
}

Statement unpack(const std::vector<std::byte>& bytes) {
    ByteReader in(bytes, "what a process was started with");
    Statement statement;
    if (!in.read<bool>()) {
        const auto code = in.read<ExitCode>();
        std::string problem = in.read_string();
        statement.error = Error{std::move(problem), in.read_string(), code};
        return statement;
    }
    for (auto left = in.read_count(sizeof(Claim::hash)); left > 0; --left) {
        Claim claim;
        claim.hash = in.read<std::uint64_t>();
        claim.code = in.read<ExitCode>();
        claim.name = in.read_string();
        claim.shown = in.read_string();
        statement.claims.push_back(std::move(claim));
    }
    return statement;
}

// "process 3", "processes 0, 2 to 5 and 9".
std::string name_processes(const std::vector<std::size_t>& numbers) {
    std::vector<std::string> runs;
    for (std::size_t i = 0; i < numbers.size();) {
        std::size_t end = i + 1;
        while (end < numbers.size() && numbers[end] == numbers[end - 1] + 1) ++end;
        if (end - i > 2)
            runs.push_back(fmt::format("{} to {}", numbers[i], numbers[end - 1]));
        else
            for (std::size_t j = i; j < end; ++j) runs.push_back(std::to_string(numbers[j]));
        i = end;
    }
    std::string text = numbers.size() == 1 ? "process " : "processes ";
    for (std::size_t i = 0; i < runs.size(); ++i) text += (i == 0 ? "" : i + 1 == runs.size() ? " and " : ", ") + runs[i];
    return text;
}

// "--ticks (5 on process 0, 7 on processes 1 to 3)"; empty if all have the same.
std::string difference(const std::vector<Statement>& all, std::size_t which) {
    struct Group {
        std::uint64_t hash;
        std::string shown;
        std::vector<std::size_t> processes;
    };
    std::vector<Group> groups;
    for (std::size_t p = 0; p < all.size(); ++p) {
        const Claim& claim = all[p].claims[which];
        const auto found = std::find_if(groups.begin(), groups.end(), [&](const Group& g) { return g.hash == claim.hash; });
        if (found != groups.end())
            found->processes.push_back(p);
        else
            groups.push_back({claim.hash, claim.shown, {p}});
    }
    if (groups.size() == 1) return "";
    // A file may have one name but different contents.
    const bool one_name = std::all_of(groups.begin(), groups.end(), [&](const Group& g) { return g.shown == groups[0].shown; });
    std::string text;
    for (const Group& group : groups) {
        const std::string shown = group.shown.empty() ? "none" : group.shown;
        text += fmt::format("{}{}{} on {}", text.empty() ? "" : ", ", shown, one_name ? fmt::format(" with hash {:016x}", group.hash) : "",
                            name_processes(group.processes));
    }
    return fmt::format("{} ({})", all[0].claims[which].name, text);
}

// The first process with an error, and whether all have that error.
std::optional<Error> first_error(const std::vector<Statement>& all) {
    const auto failed = std::find_if(all.begin(), all.end(), [](const Statement& s) { return s.error.has_value(); });
    if (failed == all.end()) return std::nullopt;
    Error error = *failed->error;
    const bool alike =
        std::all_of(all.begin(), all.end(), [&](const Statement& s) { return s.error && s.error->problem == error.problem; });
    if (!alike && !error.problem.empty()) error.problem = fmt::format("on process {}: {}", failed - all.begin(), error.problem);
    return error;
}

}  // namespace

Result<void> agree(comm::Communicator& comm, const Result<std::vector<Claim>>& mine) {
    if (comm.processes() == 1) return mine ? Result<void>{} : tl::unexpected<Error>(mine.error());
    std::vector<Statement> all;
    for (const auto& bytes : comm.allgather_any(pack(mine))) all.push_back(unpack(bytes));
    if (std::optional<Error> error = first_error(all)) return tl::unexpected<Error>(std::move(*error));
    std::string differences;
    ExitCode code = ExitCode::Fine;
    const auto as_many = [&](const Statement& s) { return s.claims.size() == all[0].claims.size(); };
    if (!std::all_of(all.begin(), all.end(), as_many)) return fail("the processes of this run have different versions of Claymeld");
    for (std::size_t i = 0; i < all[0].claims.size(); ++i) {
        const std::string one = difference(all, i);
        if (one.empty()) continue;
        differences += (differences.empty() ? "" : "; ") + one;
        code = std::max(code, all[0].claims[i].code);
    }
    if (differences.empty()) return {};
    return fail("the processes of this run differ in " + differences, "Start all of them with the same program, world and options", code);
}

}  // namespace meld::driver
