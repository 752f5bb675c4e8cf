// The folder of compiled modules, addressed by content and shared by all processes of a user.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "runtime/base/error.h"
#include "runtime/base/temporary_files.h"

namespace meld {

// The ends of the names of what is in the cache: modules, and pieces of long modules (pieces.h).
inline constexpr const char* kModuleExtension = ".so";
inline constexpr const char* kPieceExtension = ".piece";

struct CacheLimits {
    std::size_t files = 256;  // Modules.
    std::size_t pieces = 4096;
    // All together.
    std::uintmax_t size_bytes = std::uintmax_t{512} << 20;
};

// $CLAYMELD_CACHE, $XDG_CACHE_HOME/claymeld or $HOME/.cache/claymeld: the first whose variable is set; otherwise .cache/claymeld in the
// home folder that the system has for this user. Empty if there is none: a folder that others may write to is not safe.
std::string default_cache_dir();

// Makes the folder and its parents, for this user only. A module is a program, and loading it runs it, so nobody else may be able to put
// one here. Errors: there is no folder (its name is empty), it cannot be made, it belongs to another user, others may enter it, or somebody
// may put another folder in its place.
Result<void> make_cache_dir(const std::string& folder);

// Removes the least recently used modules and pieces until the limits hold, but never `keep`, and temporary files left by killed
// processes. Other processes may do the same at the same time.
void evict(const std::string& folder, const std::string& keep, const CacheLimits& limits);

// Marks a module as used just now.
void touch(const std::string& path);

// A file in the cache that is removed again unless it is published. Its name cannot be known before it exists.
class TemporaryFile {
  public:
    TemporaryFile(const std::string& folder, const std::string& suffix);
    ~TemporaryFile();
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;

    const std::string& path() const { return path_; }
    Result<void> write(const std::string& bytes) const;
    // Whether the disk now has room for a file of this size, for callers that cannot handle a full disk. Leaves nothing there.
    Result<void> check_space(std::size_t size_bytes) const;
    // Renames the file to its final name in one step; the last writer wins, and all contents are equivalent.
    Result<void> publish(const std::string& final_path);

  private:
    tl::unexpected<Error> failed(int error_number) const;

    std::string path_;
    Leftover leftover_;
    bool published_ = false;
};

}  // namespace meld
