// The ELF note that says what a compiled module was built for. It is read from the file's bytes before the module is opened, because
// opening a shared object already runs its constructors.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "runtime/base/error.h"

namespace meld {

inline constexpr std::string_view kModuleNoteSection = ".note.claymeld";
inline constexpr std::string_view kModuleNoteOwner = "Claymeld";
inline constexpr std::uint32_t kModuleNoteType = 1;
inline constexpr std::string_view kModuleNoteMagic = "MELDMOD1";

// The content of the note in the file, little-endian.
struct ModuleNoteBytes {
    char magic[8];
    std::uint32_t abi_version;
    std::uint32_t size_bytes;  // of this struct
    std::uint64_t schema_hash;
    std::uint64_t checksum;  // XXH3 of the whole file with these eight bytes left out; see seal_module
    char target[16];         // the processor it needs, padded with zeros: "x86-64-v3"
};
static_assert(sizeof(ModuleNoteBytes) == 48);

struct ModuleNote {
    std::uint32_t abi_version = 0;
    std::uint64_t schema_hash = 0;
    std::uint64_t checksum = 0;
    std::string target;
};

// Reads the note of a module given as the bytes of its file and compares its checksum with them. Every offset is checked against the size,
// so any bytes may be passed. Errors carry ExitCode::ModuleRefused and no file name.
Result<ModuleNote> read_module_note(std::span<const std::byte> file);

// Fills in the checksum of a freshly linked module. Nothing in the file may change afterwards.
Result<void> seal_module(std::span<std::byte> file);

// The whole file, or the reason why it cannot be read (ExitCode::UsageOrWorld).
Result<std::string> read_module_file(const std::string& path);

inline std::span<const std::byte> as_bytes(std::string_view text) { return std::as_bytes(std::span(text)); }

// The processor a module built here is compiled for: the newest of a few fixed levels that this machine has, so that one
// module serves a whole cluster and a cache can be shared.
std::string host_target();

// Whether this machine can execute a module built for `target`.
bool host_runs(std::string_view target);

}  // namespace meld
