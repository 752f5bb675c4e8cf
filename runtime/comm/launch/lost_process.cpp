#include "runtime/comm/launch/lost_process.h"

#include <unistd.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace meld::comm {

LostProcess::LostProcess(std::span<const liveness::Place> places, pid_t mpirun, ProgramFile program)
    : LostProcess(places, mpirun, program, Patience()) {}

LostProcess::LostProcess(std::span<const liveness::Place> places, pid_t mpirun, ProgramFile program, Patience patience)
    : places_(places), mpirun_(mpirun), program_(program), patience_(patience), last_look_(Clock::now()) {}

std::size_t LostProcess::on_their_way() const {
    std::vector<pid_t> found = descendants_of(getpid());
    std::erase_if(found, [&](pid_t process) {
        const auto is_of = [&](const liveness::Place& place) { return place.process.load() == process; };
        return program_of(process) != program_ || std::ranges::any_of(places_, is_of);
    });
    return found.size();
}

LostProcess::Sees LostProcess::state() {
    std::size_t come = 0, ended = 0, here = 0;
    for (const liveness::Place& place : places_) {
        if (place.process.load() == 0) continue;
        ++come;
        here = std::max(here, static_cast<std::size_t>(std::max(0, place.here.load())));
        if (!has_ended(place.process.load())) continue;
        if (!place.left.load()) return Sees::Gone;
        ++ended;
    }
    if (ended == places_.size()) return Sees::AllEnded;
    if (come > 0 && come >= here) return Sees::Nothing;
    const std::size_t coming = on_their_way();
    most_here_ = std::max(most_here_, coming + come);
    return coming + come < std::max(here, most_here_) ? Sees::NeverCame : Sees::Nothing;
}

LostProcess::Sees LostProcess::look() {
    const Clock::time_point now = Clock::now();
    if (places_.empty() || now < last_look_ + patience_.between_looks) return Sees::Nothing;
    const double since = std::min(kMaxBetweenLooks_s, std::chrono::duration<double>(now - last_look_).count());
    last_look_ = now;
    const Sees before = std::exchange(sees_, is_stopped(mpirun_) ? Sees::Nothing : state());
    seconds_ = sees_ != before ? 0 : seconds_ + since;
    return seconds_ >= (sees_ == Sees::NeverCame ? patience_.coming_s : patience_.gone_s) ? sees_ : Sees::Nothing;
}

}  // namespace meld::comm
