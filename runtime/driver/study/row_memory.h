// The memory of a row of a study: what it is expected to take, said before it takes it, and the word on which it does.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "runtime/base/error.h"

namespace meld::driver {

// What a run says of itself when its catoms have been counted.
struct RowMemory {
    std::uint64_t peak = 0;      // What it may have at the most, as computed from program and world.
    std::uint64_t resident = 0;  // What it has now,
    std::uint64_t own = 0;       // and how much of that since it began; resident counts what it shares with the others.
    std::uint64_t start = 0;     // own_memory() when it began.
    // What it will have taken since it began, if it comes to this peak.
    std::uint64_t own_at(std::uint64_t peak_bytes) const { return own + (peak_bytes > resident ? peak_bytes - resident : 0); }
};

// One line, and back; nothing: it is no such line.
std::string to_line(const RowMemory& memory);
std::optional<RowMemory> row_memory(std::string_view line);

// On which a process waits for a word of the one that has started it.
class Gate {
  public:
    // Before the process is started. Errors: there can be no further file.
    static Result<Gate> make();
    Gate(Gate&& other) noexcept;
    Gate& operator=(Gate&& other) noexcept;
    ~Gate();

    void open() const;
    // In the process that waits. Errors: a signal has asked for its end.
    Result<void> wait() const;

  private:
    Gate() = default;
    int descriptor_ = -1;
};

}  // namespace meld::driver
