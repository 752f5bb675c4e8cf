#include "runtime/sim/watchers/printer.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "runtime/base/bytes.h"
#include "runtime/base/files/standard_streams.h"
#include "runtime/base/terminal/progress.h"
#include "runtime/base/terminal/terminal_text.h"
#include "runtime/comm/transport/collective_result.h"
#include "runtime/engine/tuple/values.h"
#include "runtime/module/abi/actions.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

namespace {

// The number of a catom and its output.
using Line = std::pair<std::uint64_t, std::string>;

void unpack(std::span<const std::byte> bytes, std::vector<Line>& lines) {
    ByteReader in(bytes, "printed lines");
    while (!in.done()) {
        const auto id = in.read<std::uint64_t>();
        lines.emplace_back(id, in.read_string());
    }
}

}  // namespace

Result<void> Printer::start(Subdomain& subdomain) {
    prints_ = subdomain.program_actions.uses(ActionKind::Print) || subdomain.program_actions.uses(ActionKind::WriteString);
    return {};
}

Result<void> Printer::after(Subdomain& subdomain) {
    // The same on all processes, so that all exchange or none does.
    if (!prints_ || subdomain.totals.actions == 0) return {};
    ByteWriter mine;
    for (const eval::Action& a : subdomain.actions()) {
        const ActionKind kind = subdomain.kind_of(a);
        if (info(kind).performer != ActionInfo::Performer::Printer) continue;
        const std::uint64_t id = subdomain.ensemble.id(a.catom);
        const std::string line = kind == ActionKind::Print ? fmt::format("@{}: {}", id, tuple::bytes_of(a.arguments[0].list))
                                                           : std::string(tuple::bytes_of(a.arguments[0].list));
        mine.write(id);
        mine.write_string(line);
    }
    // To process 0, which keeps its own.
    std::vector<comm::Packet> packets;
    if (subdomain.comm.process() != 0 && !mine.empty()) packets.push_back({0, mine.take()});
    if (subdomain.comm.processes() > 1) packets = subdomain.comm.exchange(std::move(packets));
    if (subdomain.comm.process() != 0) return comm::outcome_of_first(subdomain.comm, {});
    std::vector<Line> lines;
    unpack(mine.view(), lines);
    for (const comm::Packet& packet : packets) unpack(packet.bytes, lines);
    std::sort(lines.begin(), lines.end());
    std::string text;
    for (const auto& [id, line] : lines) text += visible(line) + "\n";
    if (!text.empty()) clear_progress();
    return comm::outcome_of_first(subdomain.comm, text.empty() ? Result<void>{} : print(to_, text));
}

}  // namespace meld::sim
