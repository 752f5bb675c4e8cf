// What catoms tell all their neighbours alike in one tick, where it stays until the neighbours read it in the next: an entry a catom for
// each of these columns, instead of a row for each receiver. Entries of two ticks take turns, since catoms read those of the last tick
// while others write new ones.
#pragma once

#include <array>
#include <cstddef>
#include <cstring>
#include <vector>

#include "runtime/module/abi/module_abi.h"

namespace meld::eval {

class Agenda;

class Broadcasts {
  public:
    explicit Broadcasts(const ModuleInfo& module);

    // Before an evaluation, which reads what was left. leave: what it says stays here too. Cost: of the first time, memory for all catoms;
    // else nothing.
    void begin(SubdomainView& subdomain, bool leave, std::size_t catoms);
    // After it: marks the receivers of what it has left. Cost: a byte of each catom is read.
    void end(Agenda& agenda);

    // Whether something was left that nobody has read; and delivered() if it has been given to its receivers otherwise.
    bool waiting() const { return waiting_; }
    void delivered() { waiting_ = false; }
    // Calls visit(catom, const u8* row) for what was left of a column, in the order of catoms.
    template <class Visit>
    void each(u16 column, const Visit& visit) const {
        const Column& c = of(column);
        const u8* entry = c.entries[last_].data() + c.entry_bytes;
        for (u32 catom = 0; catom < c.catoms[last_]; ++catom, entry += c.entry_bytes) {
            u64 round;
            std::memcpy(&round, entry, sizeof round);
            if (round == round_) visit(catom, entry + sizeof round);
        }
    }
    std::size_t bytes() const;

  private:
    struct Column {
        u16 number = 0;
        u64 entry_bytes = 0;
        // With one more in front, of nobody: by turns.
        std::array<std::vector<u8>, 2> entries;
        std::array<std::size_t, 2> catoms = {};
        std::vector<u8> woken;  // With some in front.
    };
    // In front of those of catoms, so that theirs lie on whole words.
    static constexpr std::size_t kFront = 64;
    const Column& of(u16 column) const;

    const ModuleInfo& module_;
    std::vector<Column> columns_;
    std::vector<Broadcast> views_;  // By column of the module.
    std::size_t last_ = 0;          // Which entries are those of the last evaluation.
    u64 round_ = 0;                 // Of the last evaluation. Entries that have never been written are of round 0.
    bool waiting_ = false;
};

}  // namespace meld::eval
