// Output for users: every file that a command makes at a path given by the user goes through here.
//
// The file at the path is respected. A device, a FIFO or a socket is written to. A symbolic link is followed. A regular file keeps its mode
// and owner, and is replaced only when the new one is complete. Temporary files are beside the result, under unused names.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "runtime/base/error.h"
#include "runtime/base/files/output_lock.h"
#include "runtime/base/temporary_files.h"

namespace meld {

// Names of files beside it use this many bytes of a name; a name may have 255.
inline constexpr std::size_t kMostOfAName = 200;

// What messages call standard output, instead of a path.
inline constexpr const char* kStandardOutput = "standard output";

// The error for a file that cannot be written, from the system's error number: the reason in words, and exit code 4 if the path is not the
// cause: a full disk, a limit, a reader that has left. Without words if it is the reader of standard output: see print_error().
Error cannot_write(const std::string& path, int error_number);

// When a new file appears at its path.
enum class Appears {
    // At commit(); without it nothing changes.
    Whole,
    // From the start on, and it stays if anything has been written, even without commit(): for results that grow during a run. If there is
    // already a file, the new one grows beside it and replaces it at commit().
    AtOnce,
    // The same from appear() on, for what cannot be read before. Without it nothing has changed.
    OnceReadable,
};

// Whether results must survive a stop of the machine, not only of the process.
enum class Durability { Process, Machine };

class OutputFile {
  public:
    // Reserves the path for this process; "-" is standard output. Errors: it cannot be written, or another process writes it.
    static Result<OutputFile> open(const std::string& path, Appears appears, Durability durability = Durability::Process);

    // Goes on with a regular file that an earlier process opened and has perhaps not committed: it is at `place`, where place() said, or
    // at the path itself by now. Writing goes on after its first `size` bytes; what follows them is still there. Errors: it is gone, or
    // shorter; those of open().
    static Result<OutputFile> reopen(const std::string& path, const std::string& place, std::uint64_t size, Durability durability);

    OutputFile(OutputFile&& other) noexcept;
    OutputFile& operator=(OutputFile&& other) = delete;
    ~OutputFile();

    // Appends. After the first failure nothing more is written, and flush() and commit() report it.
    void write(std::string_view text);
    // Takes so much space on the disk for what is to be written, so that it does not become full in the middle; without effect where the
    // file system cannot do that. Errors: there is not so much.
    Result<void> reserve(std::uint64_t bytes);
    // Overwrites the bytes at this position and after it. Only for regular files, see names_stream().
    void replace_from(std::uint64_t offset, std::string_view text);
    // Hands everything written to the system or, if it must survive a stop of the machine, to the disk.
    Result<void> flush();
    // The same, and to the disk in any case, with its name in the folder.
    Result<void> sync();
    // What there is can be read, and stays if anything has been written: see Appears::OnceReadable. Only the first call counts.
    Result<void> appear();
    // The file is whole: it gets its mode and owner and its place. Nothing may be written afterwards.
    Result<void> commit();

    // Whether the path is that of a device, a FIFO, a socket or standard output: written to, never replaced.
    static bool names_stream(const std::string& path);
    // How many bytes have been written, of a regular file that is only appended to.
    std::uint64_t size() const { return offset_ + waiting_.size(); }
    // The last bytes of all that has been written, at most so many.
    Result<std::string> read_end(std::size_t most);
    // Where the bytes are for now; the file is created if necessary, so that a library can open it. Only for regular files.
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
    void put(std::string_view text);
    Result<void> sync_name();
    void set_error(int error_number);
    // If the process ends before commit().
    bool stays() const { return committed_ || (written_ && (appears_ == Appears::AtOnce || appeared_)); }

    std::string shown_;   // As the user wrote it.
    std::string target_;  // Links followed; for a regular file.
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
    bool reserved_ = false;
    std::uint64_t offset_ = 0;  // The offset of the waiting bytes in a regular file.
    // Up to where the disk was told to begin.
    std::uint64_t begun_ = 0;
    std::string waiting_;
};

// Writes a file with this text at this path, completely or not at all.
Result<void> write_file(const std::string& path, std::string_view text);

}  // namespace meld
