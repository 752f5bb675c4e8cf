// A handler may read the list at any moment, so entries are never changed or given back, only marked.
#include "runtime/base/temporary_files.h"

#include <unistd.h>

#include <cerrno>
#include <utility>

namespace meld {

struct Leftover::Entry {
    std::string path;
    Entry* older;
    std::atomic<bool> is_there{true};
};

constinit std::atomic<Leftover::Entry*> Leftover::newest{nullptr};

Leftover::Leftover(const std::string& path) : entry_(new Entry{path, newest.load()}) {
    while (!newest.compare_exchange_weak(entry_->older, entry_)) {
    }
}

Leftover::Leftover(Leftover&& other) noexcept : entry_(std::exchange(other.entry_, nullptr)) {}

Leftover& Leftover::operator=(Leftover&& other) noexcept {
    std::swap(entry_, other.entry_);
    return *this;
}

Leftover::~Leftover() {
    if (entry_ != nullptr) entry_->is_there.store(false);
}

void Leftover::remove_all() {
    for (const Entry* entry = newest.load(); entry != nullptr; entry = entry->older)
        if (entry->is_there.load() && unlink(entry->path.c_str()) != 0 && errno == EISDIR) rmdir(entry->path.c_str());
}

}  // namespace meld
