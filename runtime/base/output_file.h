// What is written for users: every file that a command makes at a path of theirs goes through here.
//
// The path is the user's. A device, a FIFO or a socket is written to. A symbolic link is followed. A regular file keeps its mode and
// owner, and is replaced only when the new one is whole. Temporary files stand beside their result, under names that nobody has.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "runtime/base/error.h"
#include "runtime/base/leftovers.h"
#include "runtime/base/output_lock.h"

namespace meld {

// So many bytes of a name go into the names of files beside it; a name may have 255.
inline constexpr std::size_t kMostOfAName = 200;

// The error of a file that cannot be written, by the system's number: the reason in words, and exit code 4 for what is no fault of
// the path: a full disk, a limit, a reader that is gone.
Error cannot_write(const std::string& path, int error_number);

// When a new file stands at its path.
enum class Appears {
    // At commit(); without it nothing has changed.
    Whole,
    // From the start on, and it stays if anything has been written, also without commit(): results that grow during a run. Where a
    // file is already, the new one grows beside it and replaces it at commit().
    AtOnce,
    // The same from appear() on, for what cannot be read before. Without it nothing has changed.
    OnceReadable,
};

// Whether results must survive that the machine stops, not only the process.
enum class Durability { Process, Machine };

class OutputFile {
  public:
    // Takes the path for this process; "-" is standard output. Errors: it cannot be written, or another process writes it.
    static Result<OutputFile> open(const std::string& path, Appears appears, Durability durability = Durability::Process);

    OutputFile(OutputFile&& other) noexcept;
    OutputFile& operator=(OutputFile&& other) = delete;
    ~OutputFile();

    // Appends. The first failure sticks: nothing more is written, and flush() and commit() tell it.
    void write(std::string_view text);
    // Replaces what stands at this place and after it. Only for regular files, see names_stream().
    void replace_from(std::uint64_t offset, std::string_view text);
    // All that has been written is given to the system or, if it must survive the machine, to the disk.
    Result<void> flush();
    // What there is can be read, and stays if anything has been written: see Appears::OnceReadable. Only the first call counts.
    Result<void> appear();
    // The file is whole: it gets its mode and owner and its place. Nothing may be written afterwards.
    Result<void> commit();

    // Whether the path is that of a device, a FIFO, a socket or standard output: something that is written to and never replaced.
    static bool names_stream(const std::string& path);
    // Where the bytes are for now; made if need be, so that a library can open it. Only for regular files.
    Result<std::string> place();
    // Where a regular file will be, links followed.
    const std::string& target() const { return target_; }
    // The file at place() has been written by somebody else.
    void note_written();

  private:
    OutputFile(std::string shown, Durability durability) : shown_(std::move(shown)), durability_(durability) {}
    static Result<OutputFile> open_regular(const std::string& shown, const std::string& target, Appears appears, Durability durability);
    bool make_file();
    void give_to_system();
    void set_error(int error_number);
    // If the process ends before commit().
    bool stays() const { return committed_ || (written_ && (appears_ == Appears::AtOnce || appeared_)); }

    std::string shown_;   // As the user wrote it.
    std::string target_;  // Links followed; of a regular file.
    std::string beside_;  // While the bytes are not at the target.
    std::optional<OutputLock> lock_;
    Leftover leftover_;
    Durability durability_;
    Appears appears_ = Appears::Whole;
    int descriptor_ = -1;
    bool stream_ = false;
    bool at_target_ = false;
    bool appeared_ = false;
    bool written_ = false;
    bool committed_ = false;
    int error_ = 0;
    std::uint64_t offset_ = 0;  // Of what waits, in a regular file.
    std::string waiting_;
};

// A file with this text at this path, as a whole or not at all.
Result<void> write_file(const std::string& path, std::string_view text);

}  // namespace meld
