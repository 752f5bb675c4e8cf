// One writer at a time for a path: a lock that the system releases when the process ends, for any reason.
#pragma once

#include <optional>
#include <string>
#include <utility>

#include "runtime/base/error.h"
#include "runtime/base/temporary_files.h"

namespace meld {

// Held by an empty file beside the output, `.NAME.claymeld-lock`, which is removed when the lock is released; a lock that a killed process
// has left is taken over. Without effect if the file system has no locks.
class OutputLock {
  public:
    // The folder of `path` must exist. Errors: another process, which the error names, writes to this path; the folder cannot be written.
    // `shown` is the path as the user wrote it.
    static Result<OutputLock> take(const std::string& path, const std::string& shown);

    // The name of the output, if a file with this name is the lock of one.
    static std::optional<std::string> locked_by(const std::string& name);

    // Notes the name of a file beside the output that has no value if this process is killed.
    void note(const std::string& name) const;
    // The name that the last holder has noted, if it was killed; whoever can write to the folder may have written it. Empty: none.
    const std::string& left_behind() const { return left_behind_; }

    OutputLock(OutputLock&& other) noexcept;
    OutputLock& operator=(OutputLock&& other) noexcept;
    ~OutputLock();

  private:
    OutputLock(std::string file, int descriptor, std::string left_behind)
        : leftover_(file), file_(std::move(file)), descriptor_(descriptor), left_behind_(std::move(left_behind)) {}

    Leftover leftover_;
    std::string file_;
    int descriptor_;
    std::string left_behind_;
};

}  // namespace meld
