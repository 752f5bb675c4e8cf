// Checkpoints that are not as they were written, byte by byte: each is refused with a reason, and the one before it is used.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>

#include "runtime/comm/transport/communicator.h"
#include "runtime/sim/state/checkpoint_folder.h"

namespace meld::sim {
namespace {

namespace fs = std::filesystem;

Block block(std::size_t size, int shift) {
    Block out(size);
    for (std::size_t i = 0; i < size; ++i) out[i] = static_cast<std::byte>(i * 7 + static_cast<std::size_t>(shift));
    return out;
}

std::string read(const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

void write(const fs::path& path, const std::string& text) { std::ofstream(path, std::ios::binary | std::ios::trunc) << text; }

// What there is of a checkpoint after any accident to one of its files: it ends early, has other bits, or more bytes.
template <class Visit>
void each_damage(const std::string& whole, const Visit& visit) {
    for (std::size_t at = 0; at < whole.size(); ++at) {
        SCOPED_TRACE("byte " + std::to_string(at) + " of " + std::to_string(whole.size()));
        visit(whole.substr(0, at));
        for (const int flip : {0x01, 0x10, 0x80, 0xff}) {
            std::string other = whole;
            other[at] = static_cast<char>(other[at] ^ flip);
            visit(other);
        }
        if (testing::Test::HasFailure()) return;
    }
    visit(whole + '\0');
    visit(whole + whole);
    visit(std::string(whole.size(), '\0'));
}

class Damage : public testing::Test {
  protected:
    Damage() {
        fs::remove_all(folder_);
        Result<CheckpointFolder> folder = CheckpointFolder::open(folder_.string(), CheckpointFolder::Run::Begins, *comm_);
        checkpoints_.emplace(std::move(*folder));
        for (const int tick : {10, 20}) {
            Manifest manifest;
            manifest.tick = tick;
            manifest.run = {.traits = {{"the world", "w.toml", 7}}, .folder = "/", .command = {"run", "p"}};
            EXPECT_TRUE(checkpoints_->write(
                manifest,
                [&](ShareSink& sink) -> Result<void> {
                    for (const std::size_t size : {1U, 40U}) EXPECT_TRUE(sink.chunk({block(size, tick), block(2 * size + 3, 1)}));
                    EXPECT_TRUE(sink.chunk({block(0, 0), block(0, 0)}));
                    return sink.rest(block(17, tick));
                },
                [] { return std::string("0123456789abcdef"); }, *comm_));
        }
    }
    ~Damage() override { fs::remove_all(folder_); }

    // Whichever checkpoint is the newest that is whole, and what is said of the other.
    void expect_newest(std::int64_t tick, const std::string& says) {
        const Result<OpenCheckpoint> newest = checkpoints_->newest(*comm_);
        ASSERT_TRUE(newest.has_value()) << newest.error().message();
        const std::string& passed_over = newest->checkpoint.passed_over;
        EXPECT_EQ(newest->checkpoint.manifest.tick, tick);
        EXPECT_NE(passed_over.find(says), std::string::npos) << passed_over;
        EXPECT_EQ(passed_over.empty(), says.empty()) << passed_over;
    }

    const fs::path folder_ = fs::temp_directory_path() / ("damage_test_" + std::to_string(getpid()));
    std::unique_ptr<comm::Communicator> comm_ = comm::make_single();
    std::optional<CheckpointFolder> checkpoints_;
};

TEST_F(Damage, OfAnyByteOfAShareIsNoticed) {
    const fs::path share = folder_ / "20.0-of-1.share";
    const std::string whole = read(share);
    ASSERT_GT(whole.size(), 250U);
    each_damage(whole, [&](const std::string& data) {
        write(share, data);
        expect_newest(10, share.string());
    });
    write(share, whole);
    expect_newest(20, "");
}

TEST_F(Damage, OfAnyByteOfAManifestIsNoticed) {
    const fs::path manifest = folder_ / "20.checkpoint.json";
    const std::string whole = read(manifest);
    ASSERT_GT(whole.size(), 250U);
    each_damage(whole, [&](const std::string& data) {
        write(manifest, data);
        expect_newest(10, manifest.string());
    });
    write(manifest, whole);
    expect_newest(20, "");
}

TEST_F(Damage, FilesOfAnotherCheckpointAreNoticed) {
    fs::copy_file(folder_ / "10.checkpoint.json", folder_ / "30.checkpoint.json");
    expect_newest(20, "the manifest is of another checkpoint");
    fs::remove(folder_ / "20.0-of-1.share");
    fs::create_directory(folder_ / "20.0-of-1.share");
    expect_newest(10, "is missing, or no file of ours");
}

// A run that goes on removes old checkpoints while another one reads them.
TEST_F(Damage, AnOpenCheckpointCanBeReadToItsEnd) {
    const Result<OpenCheckpoint> newest = open_newest(folder_.string(), *comm_);
    ASSERT_TRUE(newest.has_value()) << newest.error().message();
    fs::remove_all(folder_);
    EXPECT_TRUE(newest->shares.check().has_value());
    EXPECT_FALSE(open_newest(folder_.string(), *comm_).has_value());
}

// It may remove all that were there when the reader began to look.
TEST_F(Damage, IsNotThatOfARunThatGoesOn) {
    std::jthread run([this](const std::stop_token& end) {
        for (std::int64_t tick = 30; !end.stop_requested(); ++tick) {
            Manifest manifest;
            manifest.tick = tick;
            const auto save = [](ShareSink& sink) { return sink.rest(block(17, 0)); };
            ASSERT_TRUE(checkpoints_->write(manifest, save, [] { return std::string("0123456789abcdef"); }, *comm_));
        }
    });
    const auto reader = comm::make_single();
    for (int i = 0; i < 2000; ++i) {
        const Result<Manifest> manifest = newest_manifest(folder_.string());
        ASSERT_TRUE(manifest.has_value()) << manifest.error().message();
        const Result<OpenCheckpoint> newest = open_newest(folder_.string(), *reader);
        ASSERT_TRUE(newest.has_value()) << newest.error().message();
    }
}

TEST_F(Damage, OfAllIsAnError) {
    for (const int tick : {10, 20}) {
        const fs::path share = folder_ / (std::to_string(tick) + ".0-of-1.share");
        write(share, read(share).substr(0, 100));
    }
    const Result<OpenCheckpoint> newest = checkpoints_->newest(*comm_);
    ASSERT_FALSE(newest.has_value());
    EXPECT_EQ(newest.error().code, ExitCode::RecordingRefused);
    EXPECT_NE(newest.error().problem.find("10.0-of-1.share"), std::string::npos) << newest.error().problem;
    EXPECT_NE(newest.error().problem.find("20.0-of-1.share"), std::string::npos) << newest.error().problem;
}

}  // namespace
}  // namespace meld::sim
