// Work in a process that begins as a copy of this one: whatever becomes of it, this one does not see it. The copy has a pipe to this
// process and a file in memory, which both know.
#pragma once

#include <sys/resource.h>
#include <sys/types.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "runtime/base/error.h"

namespace meld {

// Writes all of the bytes, however many calls it takes; false: it cannot, and errno says why.
bool write_all(int descriptor, std::string_view bytes);
// All that there is in a file, from its beginning.
std::string read_from_start(int descriptor);

// The bytes of address space that this process has.
std::uint64_t address_space_bytes();
// Sets a limit of this process, as setrlimit knows them, to `most`, or to the greatest that it may have.
void set_limit(int resource, std::uint64_t most);

class CopiedProcess {
  public:
    // Whether signals that a terminal sends to this process, as on ctrl-C, reach the copy too.
    enum class Signals { Shared, Apart };
    // What the copy does, with its end of the pipe and the file; it ends when this returns.
    using Work = std::function<void(int pipe, int file)>;

    // Starts a copy. It reads nothing, and it ends with this process. Errors: there can be no further process, pipe
    // or file.
    static Result<CopiedProcess> start(const Work& work, Signals signals);
    CopiedProcess(CopiedProcess&& other) noexcept;
    CopiedProcess& operator=(CopiedProcess&& other) noexcept;
    // A copy that has not ended is killed; if its signals are apart, with all that it has started.
    ~CopiedProcess();

    // This process's end of the pipe: readable when there is something to read, or the copy has ended.
    int pipe() const { return pipe_; }
    int file() const { return file_; }
    pid_t id() const { return process_; }

    struct End {
        int status = 0;  // As waitpid has it.
        rusage used{};   // With what its children have used.
    };
    // How it has ended; nothing: it goes on. Not to be called after it has ended.
    std::optional<End> ended() { return wait(false); }
    // Waits until it has ended; to be called once.
    End end() { return *wait(true); }
    void kill();

  private:
    CopiedProcess() = default;
    std::optional<End> wait(bool until_it_ends);
    // A process, or, negative, a group of them.
    pid_t whom() const { return signals_ == Signals::Apart ? -process_ : process_; }

    Signals signals_ = Signals::Shared;
    pid_t process_ = 0;
    int pipe_ = -1, file_ = -1;
};

}  // namespace meld
