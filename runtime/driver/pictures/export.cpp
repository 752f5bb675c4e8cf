#include "runtime/driver/pictures/export.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "runtime/base/files/standard_streams.h"
#include "runtime/base/units.h"
#include "runtime/comm/transport/collective_result.h"
#include "runtime/driver/pictures/picture_options.h"
#include "runtime/show/picture/model_file.h"
#include "runtime/show/picture/palette.h"

namespace meld::driver {

namespace {

class Export {
  public:
    Export(const RunOptions& options, Onlooker& onlooker, picture::Look look, std::vector<std::int64_t> ticks)
        : options_(options), picture_(*options.debug->picture), onlooker_(onlooker), look_(std::move(look)), ticks_(std::move(ticks)) {}

    Result<int> make() {
        // Reserved before the work begins.
        Result<void> opened;
        if (onlooker_.speaks())
            opened = picture::ModelFile::open(picture_.file, ticks_.size()).map([&](auto&& file) { file_ = std::move(file); });
        if (auto fine = all(opened); !fine) return tl::unexpected<Error>(fine.error());
        const std::int64_t first = onlooker_.tick();
        // Colours are to mean the same in all ticks: what they mean is found in a first pass, and nothing is kept from it.
        if (ticks_.size() > 1 && !(look_.colour.empty() && look_.links.empty() && look_.arrows.empty())) {
            if (auto done = pass([&](picture::Frame& frame) { return include(frame); }); !done) return tl::unexpected<Error>(done.error());
            if (auto there = onlooker_.go_to(first); !there) return tl::unexpected<Error>(there.error());
            known_ = true;
        }
        if (auto done = pass([&](picture::Frame& frame) { return write(frame); }); !done) return tl::unexpected<Error>(done.error());
        if (auto done = all(onlooker_.speaks() ? finish() : Result<void>{}); !done) return tl::unexpected<Error>(done.error());
        return static_cast<int>(ExitCode::Fine);
    }

  private:
    // Calls it with each frame, on process 0.
    template <class Take>
    Result<void> pass(const Take& take) {
        std::optional<std::int64_t> last;
        for (const std::size_t i : order_of(ticks_, onlooker_.at_checkpoint())) {
            if (auto there = onlooker_.reach(ticks_[i]); !there) return there;
            // A tick that is named twice, or that is also the end, is written once.
            if (std::exchange(last, onlooker_.tick()) == onlooker_.tick()) continue;
            Result<picture::Frame> frame = onlooker_.look(look_);
            if (!frame) return tl::unexpected<Error>(frame.error());
            if (auto taken = all(onlooker_.speaks() ? take(*frame) : Result<void>{}); !taken) return taken;
        }
        return {};
    }
    Result<void> include(const picture::Frame& frame) {
        palette_.include(frame);
        return {};
    }
    Result<void> write(picture::Frame& frame) {
        if (!known_) palette_.include(frame);
        palette_.settle();
        palette_.apply(frame);
        written_.push_back(frame.tick);
        if (frame.scene.places.size() >= shown_) std::tie(shown_, catoms_) = std::pair(frame.scene.places.size(), frame.catoms);
        return file_->add(frame);
    }
    Result<void> finish() {
        if (auto done = file_->commit(); !done) return done;
        onlooker_.show_no_more();
        if (options_.json)
            return print(
                stdout,
                nlohmann::ordered_json{{"file", picture_.file}, {"ticks", written_}, {"catoms", catoms_}, {"shown", shown_}}.dump() + "\n");
        if (options_.quiet) return {};
        return print(stdout, fmt::format("{}: {} of {} catom{}, tick{} {}\n", picture_.file, grouped(shown_), grouped(catoms_),
                                         catoms_ == 1 ? "" : "s", written_.size() == 1 ? "" : "s", fmt::join(written_, ", ")));
    }
    // Of process 0, on every process.
    Result<void> all(const Result<void>& mine) { return comm::outcome_of_first(onlooker_.comm(), mine); }

    const RunOptions& options_;
    const PictureOptions& picture_;
    Onlooker& onlooker_;
    const picture::Look look_;
    const std::vector<std::int64_t> ticks_;
    picture::Palette palette_{look_};
    bool known_ = false;
    std::unique_ptr<picture::ModelFile> file_;
    std::vector<std::int64_t> written_ = {};
    std::uint64_t shown_ = 0, catoms_ = 0;
};

}  // namespace

Result<int> export_run(const RunOptions& options, Onlooker& onlooker) {
    const PictureOptions& picture = *options.debug->picture;
    const Result<picture::Look> look = look_of(picture);
    if (!look) return tl::unexpected<Error>(look.error());
    const auto ticks = ticks_of(std::get<ExportOptions>(picture.of).ticks);
    if (!ticks) return tl::unexpected<Error>(ticks.error());
    return Export(options, onlooker, *look, *ticks).make();
}

}  // namespace meld::driver
