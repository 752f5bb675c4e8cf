#include "runtime/sim/state/changed_chunks.h"

#include <algorithm>

namespace meld::sim {

void ChangedChunks::look() {
    const std::size_t chunks = (subdomain_.facts_.columns.count() + catoms_ - 1) / catoms_;
    changed_.resize(chunks, true);
    touched_.take([&](Catom catom) { changed_[catom / catoms_] = true; });
    note_agenda(changed_);
    waits_.assign(chunks, false);
}

std::vector<std::size_t> ChangedChunks::all_changed() const {
    std::vector<std::size_t> all;
    for (std::size_t chunk = 0; chunk < changed_.size(); ++chunk)
        if (changed_[chunk]) all.push_back(chunk);
    return all;
}

void ChangedChunks::saved() {
    note_agenda(waits_);
    const tuple::ChangeLog& log = subdomain_.facts_.columns.changes();
    const std::size_t count = subdomain_.facts_.columns.count();
    for (const std::size_t chunk : all_changed())
        for (std::size_t catom = chunk * catoms_; catom < std::min(count, (chunk + 1) * catoms_) && !waits_[chunk]; ++catom)
            waits_[chunk] = log.any(static_cast<Catom>(catom));
    changed_ = waits_;
}

void ChangedChunks::note_agenda(std::vector<bool>& chunks) const {
    subdomain_.agenda().each([&](Catom catom, u64) { chunks[catom / catoms_] = true; });
}

}  // namespace meld::sim
