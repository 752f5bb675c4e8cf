// Files that are no results yet: temporary ones, locks, and what has just been begun. They go when the process is ended at once, and so do
// folders of such files.
#pragma once

#include <atomic>
#include <string>

namespace meld {

// While it lives, the file at this path, or the folder, goes when the process is ended by runtime/base/process/interrupt.h. A folder goes
// after what was named later, so name it before its files.
class Leftover {
  public:
    Leftover() = default;
    explicit Leftover(const std::string& path);
    Leftover(Leftover&& other) noexcept;
    Leftover& operator=(Leftover&& other) noexcept;
    ~Leftover();

    // A handler of signals calls it, and ends the process after that.
    static void remove_all();

  private:
    struct Entry;
    static std::atomic<Entry*> newest;

    Entry* entry_ = nullptr;
};

}  // namespace meld
