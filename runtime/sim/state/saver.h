// Writes the share that this process has of a snapshot. Nothing of the run changes.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "runtime/sim/core/code_modules.h"
#include "runtime/sim/core/subdomain.h"
#include "runtime/sim/state/changed_chunks.h"
#include "runtime/sim/state/share.h"

namespace meld::sim {

// What moves, records and watches a run, in the order in which it acts. By its name a run that branches off finds what it had kept.
struct NamedModule {
    std::string name;
    SimModule* module = nullptr;
};
using Modules = std::vector<NamedModule>;

class Saver {
  public:
    // changed: if a sink has the other chunks of a lattice as they were, they are not made again.
    Saver(const Subdomain& subdomain, const Modules& modules, const CodeModules& codes, ChangedChunks* changed = nullptr)
        : subdomain_(subdomain), modules_(modules), codes_(codes), changed_(changed) {}

    // Between two ticks. `counters` is what the run has counted, which Loader gives back. Cost: a copy of what the catoms hold, a
    // chunk at a time. Errors: those of the sink.
    Result<void> run(std::span<const std::byte> counters, ShareSink& sink) const;

  private:
    Result<void> save_cells(ShareSink& sink) const;
    // Catoms at arbitrary positions: those of one home are in one chunk.
    Result<void> save_homes(ShareSink& sink) const;
    // The catoms of this process among so many indices from the first on.
    void list(std::size_t first, std::size_t count, std::vector<Catom>& catoms) const;
    // Whether modules that do not say when it changes keep anything for these catoms.
    bool any_kept_silently(std::span<const Catom> catoms) const;
    void state(std::span<const Catom> catoms, ByteWriter& out) const;
    void rest(std::span<const std::byte> counters, ByteWriter& out) const;

    const Subdomain& subdomain_;
    const Modules& modules_;
    const CodeModules& codes_;
    ChangedChunks* changed_;
};

}  // namespace meld::sim
