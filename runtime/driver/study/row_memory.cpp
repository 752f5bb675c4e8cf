#include "runtime/driver/study/row_memory.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>
#include <utility>

#include "runtime/base/process/interrupt.h"

namespace meld::driver {

namespace {

constexpr int kLookForSignals_ms = 200;

}  // namespace

std::string to_line(const RowMemory& memory) {
    return nlohmann::json{{"peak", memory.peak}, {"resident", memory.resident}, {"own", memory.own}, {"start", memory.start}}.dump() + "\n";
}

std::optional<RowMemory> row_memory(std::string_view line) {
    try {
        const nlohmann::json json = nlohmann::json::parse(line);
        return RowMemory{.peak = json.at("peak"), .resident = json.at("resident"), .own = json.at("own"), .start = json.at("start")};
    } catch (const nlohmann::json::exception&) {
        return std::nullopt;
    }
}

Result<Gate> Gate::make() {
    Gate gate;
    gate.descriptor_ = eventfd(0, EFD_CLOEXEC);
    if (gate.descriptor_ < 0) return fail(fmt::format("cannot make a file for events: {}", std::strerror(errno)), "", ExitCode::LimitHit);
    return gate;
}

Gate::Gate(Gate&& other) noexcept { *this = std::move(other); }

Gate& Gate::operator=(Gate&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
}

Gate::~Gate() {
    if (descriptor_ >= 0) close(descriptor_);
}

void Gate::open() const { static_cast<void>(eventfd_write(descriptor_, 1)); }

Result<void> Gate::wait() const {
    for (pollfd word{descriptor_, POLLIN, 0}; poll(&word, 1, kLookForSignals_ms) <= 0;)
        if (interrupt::received() != 0) return fail("interrupted", "", ExitCode::Interrupted);
    return {};
}

}  // namespace meld::driver
