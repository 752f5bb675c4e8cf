// Fuzz target: a file that passes for a share of a checkpoint is one that would be written, byte for byte; any other is refused.
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "runtime/base/assert.h"
#include "runtime/sim/state/share_file.h"

namespace {

namespace fs = std::filesystem;

// A folder of this process, which goes at its end.
struct Folder {
    fs::path path = fs::temp_directory_path() / ("claymeld_fuzz_" + std::to_string(getpid()));
    Folder() { fs::create_directories(path); }
    ~Folder() {
        std::error_code ignored;
        fs::remove_all(path, ignored);
    }
};

std::string read(const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

void write_again(const meld::sim::ShareFiles& share, const std::string& path) {
    const auto writer = meld::sim::ShareWriter::create(path);
    MELD_CHECK(writer.has_value(), "{}", writer.error().problem);
    meld::sim::Block places, state;
    for (std::size_t chunk = 0; chunk < share.chunks(0); ++chunk) {
        const auto written = (*writer)->chunk({share.places(0, chunk, places).value(), share.state(0, chunk, state).value()});
        MELD_CHECK(written.has_value(), "chunk {}", chunk);
    }
    const auto ended = (*writer)->rest(share.rest(0, state).value());
    const auto closed = (*writer)->close();
    MELD_CHECK(ended && closed, "{}", path);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const Folder folder;
    const std::string given = folder.path / "given", again = folder.path / "again";
    const std::string bytes(reinterpret_cast<const char*>(data), size);
    std::ofstream(given, std::ios::binary | std::ios::trunc) << bytes;
    const meld::Result<meld::sim::ShareFiles> share = meld::sim::ShareFiles::open({given});
    // One that refers to others is not written without them.
    if (!share || !share->check() || !share->is_whole(0)) return 0;
    write_again(*share, again);
    MELD_CHECK(read(again) == bytes, "a file of {} bytes passes for a share, and none such would be written", size);
    return 0;
}
