#include "tests/unit/runtime_comm/semantics.h"

#include <fmt/format.h>
#include <algorithm>
#include <cstring>
#include <stdexcept>

#include "runtime/base/hash.h"

namespace meld::comm::semantics {

namespace {

void require(bool condition, const Communicator& communicator, const std::string& what) {
    if (!condition) throw std::runtime_error(fmt::format("process {} of {}: {}", communicator.process(), communicator.processes(), what));
}

std::uint64_t word(std::uint64_t round, int from, int to) {
    return hash_combine(hash_combine(round, static_cast<std::uint64_t>(from)), static_cast<std::uint64_t>(to));
}

// The bytes that process `from` sends to process `to` in a round: anyone can compute them, so the receiver can check them.
std::vector<std::byte> payload(std::uint64_t round, int from, int to, std::size_t size_bytes) {
    std::vector<std::byte> bytes(size_bytes);
    std::uint64_t state = word(round, from, to);
    for (std::size_t i = 0; i < size_bytes; i += sizeof(state)) {
        state = mix64(state + i);
        std::memcpy(bytes.data() + i, &state, std::min(sizeof(state), size_bytes - i));
    }
    return bytes;
}

// A traffic says how many bytes go from one process to another in a round; negative: no packet.
using Traffic = std::int64_t (*)(std::uint64_t round, int from, int to);

void exchange_once(Communicator& communicator, std::uint64_t round, Traffic traffic) {
    const int me = communicator.process();
    std::vector<Packet> packets;
    for (int to = communicator.processes() - 1; to >= 0; --to) {
        const std::int64_t size = to == me ? -1 : traffic(round, me, to);
        if (size >= 0) packets.push_back({to, payload(round, me, to, static_cast<std::size_t>(size))});
    }
    const std::vector<Packet> received = communicator.exchange(std::move(packets));
    std::size_t next = 0;
    for (int from = 0; from < communicator.processes(); ++from) {
        const std::int64_t size = from == me ? -1 : traffic(round, from, me);
        if (size < 0) continue;
        require(next < received.size(), communicator, fmt::format("round {}: no packet of process {}", round, from));
        require(received[next].process == from, communicator, fmt::format("round {}: packets are not sorted", round));
        require(received[next].bytes == payload(round, from, me, static_cast<std::size_t>(size)), communicator,
                fmt::format("round {}: packet of process {} differs", round, from));
        ++next;
    }
    require(next == received.size(), communicator, fmt::format("round {}: {} packets too many", round, received.size() - next));
}

void knows_its_place(Communicator& communicator) {
    require(communicator.process() >= 0 && communicator.process() < communicator.processes(), communicator, "process out of range");
}

void random_sparse_rounds(Communicator& communicator) {
    for (std::uint64_t round = 0; round < 400; ++round) {
        exchange_once(communicator, round, [](std::uint64_t r, int from, int to) -> std::int64_t {
            const std::uint64_t dice = word(r, from, to);
            if (dice % 3 != 0) return -1;
            return static_cast<std::int64_t>(dice / 3 % 700);
        });
    }
}

// Processes run ahead of each other here: in most rounds only one of them has anything to say.
void lopsided_rounds(Communicator& communicator) {
    for (std::uint64_t round = 0; round < 400; ++round) {
        exchange_once(communicator, round, [](std::uint64_t r, int from, int) -> std::int64_t {
            return static_cast<std::uint64_t>(from) == r % 5 ? static_cast<std::int64_t>(r % 40) : -1;
        });
    }
}

void empty_rounds(Communicator& communicator) {
    for (std::uint64_t round = 0; round < 200; ++round)
        exchange_once(communicator, round, [](std::uint64_t, int, int) -> std::int64_t { return -1; });
}

void packets_without_bytes(Communicator& communicator) {
    for (std::uint64_t round = 0; round < 50; ++round)
        exchange_once(communicator, round, [](std::uint64_t, int, int) -> std::int64_t { return 0; });
}

// Far above the size at which MPI stops to send eagerly, and above the chunk that the MPI tests set.
void big_packets(Communicator& communicator) {
    for (std::uint64_t round = 0; round < 3; ++round) {
        exchange_once(communicator, round, [](std::uint64_t r, int from, int to) -> std::int64_t {
            return (from + to + static_cast<int>(r)) % 2 == 0 ? 3'000'001 + from : 5;
        });
    }
}

// Sizes around a chunk of 65,536 bytes: one less, exact, one more, two chunks.
void packets_of_whole_chunks(Communicator& communicator) {
    for (std::uint64_t round = 0; round < 8; ++round) {
        exchange_once(communicator, round, [](std::uint64_t r, int, int) -> std::int64_t {
            const std::int64_t sizes[] = {65'535, 65'536, 65'537, 131'072};
            return sizes[r % 4];
        });
    }
}

void gathers(Communicator& communicator) {
    for (std::uint64_t round = 0; round < 100; ++round) {
        const std::size_t size = round % 9;
        const auto all = communicator.allgather(payload(round, communicator.process(), 0, size));
        require(all.size() == size * static_cast<std::size_t>(communicator.processes()), communicator, "allgather has another size");
        for (int from = 0; from < communicator.processes(); ++from) {
            const auto expected = payload(round, from, 0, size);
            const auto begin = all.begin() + static_cast<std::ptrdiff_t>(size) * from;
            require(std::equal(expected.begin(), expected.end(), begin), communicator, "allgather differs");
        }
    }
}

void gathers_of_any_size(Communicator& communicator) {
    for (std::uint64_t round = 0; round < 60; ++round) {
        const auto size_of = [&](int process) {
            return round == 59 ? std::size_t{200'000} : static_cast<std::size_t>(word(round, process, 0) % 50);
        };
        const int me = communicator.process();
        const auto all = communicator.allgather_any(payload(round, me, 0, size_of(me)));
        require(all.size() == static_cast<std::size_t>(communicator.processes()), communicator, "allgather_any has another size");
        for (int from = 0; from < communicator.processes(); ++from)
            require(all[static_cast<std::size_t>(from)] == payload(round, from, 0, size_of(from)), communicator, "allgather_any differs");
    }
}

void all_operations_in_turn(Communicator& communicator) {
    for (std::uint64_t round = 0; round < 100; ++round) {
        exchange_once(communicator, round, [](std::uint64_t r, int from, int to) -> std::int64_t {
            return (word(r, from, to) & 1) != 0 ? static_cast<std::int64_t>(r) : -1;
        });
        if (round % 3 == 0) communicator.barrier();
        const auto all = communicator.allgather(payload(round, communicator.process(), 0, 1));
        require(all.size() == static_cast<std::size_t>(communicator.processes()), communicator, "allgather has another size");
    }
}

}  // namespace

const std::vector<Case>& all_cases() {
    static const std::vector<Case> cases = {
        {"KnowsItsPlace", knows_its_place},
        {"RandomSparseRounds", random_sparse_rounds},
        {"LopsidedRounds", lopsided_rounds},
        {"EmptyRounds", empty_rounds},
        {"PacketsWithoutBytes", packets_without_bytes},
        {"BigPackets", big_packets},
        {"PacketsOfWholeChunks", packets_of_whole_chunks},
        {"Gathers", gathers},
        {"GathersOfAnySize", gathers_of_any_size},
        {"AllOperationsInTurn", all_operations_in_turn},
    };
    return cases;
}

}  // namespace meld::comm::semantics
