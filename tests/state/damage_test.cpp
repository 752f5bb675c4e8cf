// Checkpoints that are not as they were written, byte by byte: each is refused with a reason, and the one before it is used.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <thread>
#include <vector>

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

// What there is of a checkpoint after any accident to one of its files: it ends early, has other bits, or more bytes. `step` is how many
// bytes lie between those that are hit.
template <class Visit>
void each_damage(const std::string& whole, std::size_t step, const Visit& visit) {
    for (std::size_t at = 0; at < whole.size(); at += step) {
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

// A checkpoint of a few chunks of which some are as they were, and how it was stored.
class Chains : public testing::Test {
  protected:
    Chains() { fs::remove_all(folder_); }
    ~Chains() override { fs::remove_all(folder_); }

    void open(CheckpointFolder::Run run) {
        checkpoints_.reset();
        Result<CheckpointFolder> folder = CheckpointFolder::open(folder_.string(), run, *comm_, CheckpointFolder::Stores::Changes);
        ASSERT_TRUE(folder.has_value()) << folder.error().message();
        checkpoints_.emplace(std::move(*folder));
    }
    // So many chunks are others than in checkpoints of other ticks.
    void keep(std::int64_t tick, int changed) {
        Manifest manifest;
        manifest.tick = tick;
        manifest.run = {.traits = {{"the world", "w.toml", 7}}, .folder = "/", .command = {"run", "p"}};
        const auto save = [&](ShareSink& sink) -> Result<void> {
            for (int i = 0; i < kChunks; ++i) {
                const int shift = i < changed ? static_cast<int>(tick) : 0;
                EXPECT_TRUE(sink.chunk({block(100, i), block(kBytes, i + shift)}));
            }
            return sink.rest(block(17, static_cast<int>(tick)));
        };
        const Result<void> kept = checkpoints_->write(manifest, save, [] { return std::string("0123456789abcdef"); }, *comm_);
        ASSERT_TRUE(kept.has_value()) << kept.error().message();
        changed_[tick] = changed;
    }
    // The newest that is whole gives back what was kept.
    void expect_newest(std::int64_t tick, const std::string& says) {
        const Result<OpenCheckpoint> newest = open_newest(folder_.string(), *comm_);
        ASSERT_TRUE(newest.has_value()) << newest.error().message();
        const std::string& passed_over = newest->checkpoint.passed_over;
        EXPECT_EQ(newest->checkpoint.manifest.tick, tick) << passed_over;
        EXPECT_NE(passed_over.find(says), std::string::npos) << passed_over;
        EXPECT_EQ(passed_over.empty(), says.empty()) << passed_over;
        const ShareFiles& shares = newest->shares;
        ASSERT_EQ(shares.chunks(0), static_cast<std::size_t>(kChunks));
        Block room;
        for (int i = 0; i < kChunks; ++i) {
            const int shift = i < changed_[tick] ? static_cast<int>(tick) : 0;
            EXPECT_TRUE(std::ranges::equal(shares.places(0, static_cast<std::size_t>(i), room).value(), block(100, i)));
            EXPECT_TRUE(std::ranges::equal(shares.state(0, static_cast<std::size_t>(i), room).value(), block(kBytes, i + shift)));
        }
        EXPECT_TRUE(std::ranges::equal(shares.rest(0, room).value(), block(17, static_cast<int>(tick))));
    }
    // Two checkpoints, and three of a run that goes on from them, which begin with a whole one.
    void go_on() {
        open(CheckpointFolder::Run::Begins);
        for (const std::int64_t tick : {10, 20}) keep(tick, 2);
        open(CheckpointFolder::Run::GoesOn);
        ASSERT_TRUE(checkpoints_->newest(*comm_).has_value());
        for (const std::int64_t tick : {30, 40, 50}) keep(tick, 2);
    }
    // Each accident to the last of these leaves the one before.
    void expect_fallbacks(std::size_t step) {
        const std::string last = read(share(50));
        each_damage(last, step, [&](const std::string& data) {
            write(share(50), data);
            expect_newest(40, share(50).string());
        });
        write(share(50), last);
        expect_newest(50, "");
    }
    std::vector<std::int64_t> ticks() const { return checkpoint_ticks(folder_.string()); }
    fs::path share(std::int64_t tick) const { return folder_ / (std::to_string(tick) + ".0-of-1.share"); }

    static constexpr int kChunks = 20, kBytes = 200;
    const fs::path folder_ = fs::temp_directory_path() / ("chains_test_" + std::to_string(getpid()));
    std::unique_ptr<comm::Communicator> comm_ = comm::make_single();
    std::optional<CheckpointFolder> checkpoints_;
    std::map<std::int64_t, int> changed_;
};

TEST_F(Chains, TakeWhatHasChanged) {
    open(CheckpointFolder::Run::Begins);
    for (const std::int64_t tick : {10, 20, 30}) keep(tick, 2);
    EXPECT_GT(fs::file_size(share(10)), 4000U);
    EXPECT_LT(fs::file_size(share(20)), 3000U);
    EXPECT_LT(fs::file_size(share(30)), 3000U);
    expect_newest(30, "");
    // One that is written again does not refer to itself.
    keep(30, 5);
    EXPECT_GT(fs::file_size(share(30)), 4000U);
    expect_newest(30, "");
}

TEST_F(Chains, BeginAnewByBytesAndGoInWhole) {
    open(CheckpointFolder::Run::Begins);
    std::vector<std::int64_t> whole;
    for (std::int64_t tick = 10; tick <= 300; tick += 10) {
        keep(tick, 3);
        if (fs::file_size(share(tick)) > 4000U) whole.push_back(tick);
        // What is kept are the last two chains, each from its whole one on.
        const std::int64_t first = whole.size() > 1 ? whole[whole.size() - 2] : whole[0];
        std::vector<std::int64_t> wanted;
        for (std::int64_t each = first; each <= tick; each += 10) wanted.push_back(each);
        EXPECT_EQ(ticks(), wanted);
        expect_newest(tick, "");
    }
    EXPECT_GE(whole.size(), 4U);
    EXPECT_LE(whole.size(), 15U);
    // Much has changed: the next one is whole again.
    keep(310, kChunks);
    keep(320, 0);
    EXPECT_GT(fs::file_size(share(320)), 4000U);
}

TEST_F(Chains, OfWhichTheLastFileIsDamagedFallBackToTheOneBefore) {
    go_on();
    expect_fallbacks(31);
}

TEST_F(Chains, OfWhichAnyByteOfTheLastFileIsDamagedFallBackToTheOneBefore) {
    go_on();
    expect_fallbacks(1);
}

TEST_F(Chains, OfWhichAFileIsGoneOrDamagedFallBackToTheOneBefore) {
    go_on();
    EXPECT_EQ(ticks(), (std::vector<std::int64_t>{10, 20, 30, 40, 50}));
    EXPECT_GT(fs::file_size(share(30)), 4000U);
    const std::string middle = read(share(40)), base = read(share(30));
    for (const std::string& data : {base.substr(0, base.size() / 2), std::string(base.size(), '\0'), std::string()}) {
        write(share(30), data);
        expect_newest(20, share(30).string());
    }
    fs::remove(share(30));
    expect_newest(20, share(30).string());
    write(share(30), base);
    // Nothing but one block of the one before is needed, if at all.
    fs::remove(share(40));
    const Result<OpenCheckpoint> without = open_newest(folder_.string(), *comm_);
    ASSERT_TRUE(without.has_value());
    EXPECT_TRUE(without->checkpoint.manifest.tick == 50 || without->checkpoint.manifest.tick == 30);
    write(share(40), middle);
    expect_newest(50, "");
}

TEST_F(Damage, OfAnyByteOfAShareIsNoticed) {
    const fs::path share = folder_ / "20.0-of-1.share";
    const std::string whole = read(share);
    ASSERT_GT(whole.size(), 250U);
    each_damage(whole, 1, [&](const std::string& data) {
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
    each_damage(whole, 1, [&](const std::string& data) {
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
