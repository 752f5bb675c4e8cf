#include "runtime/driver/pictures/shot.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <tuple>
#include <utility>

#include "runtime/base/files/standard_streams.h"
#include "runtime/base/process/parallel_for.h"
#include "runtime/base/process/processors.h"
#include "runtime/base/terminal/progress.h"
#include "runtime/base/units.h"
#include "runtime/comm/transport/collective_result.h"
#include "runtime/driver/pictures/picture_options.h"
#include "runtime/show/render/image.h"

namespace meld::driver {

namespace {

Result<void> report(const RunOptions& options, std::span<const picture::Frame> frames, const render::Image& image) {
    const std::string& path = options.debug->picture->file;
    std::uint64_t shown = 0, catoms = 0;
    std::vector<std::int64_t> ticks;
    for (const picture::Frame& frame : frames) {
        if (frame.scene.places.size() >= shown) std::tie(shown, catoms) = std::pair(frame.scene.places.size(), frame.catoms);
        ticks.push_back(frame.tick);
    }
    std::FILE* const talk = path == "-" ? stderr : stdout;
    if (options.json)
        return print(
            talk,
            nlohmann::ordered_json{
                {"file", path}, {"width", image.width}, {"height", image.height}, {"ticks", ticks}, {"catoms", catoms}, {"shown", shown}}
                    .dump() +
                "\n");
    if (options.quiet) return {};
    return print(talk, fmt::format("{}: {} x {} pixels, {} of {} catom{}, tick{} {}\n", path, image.width, image.height, grouped(shown),
                                   grouped(catoms), catoms == 1 ? "" : "s", ticks.size() == 1 ? "" : "s", fmt::join(ticks, ", ")));
}

// Paints the frames and writes the picture.
Result<render::Image> paint(std::span<picture::Frame> frames, const picture::Look& look, const picture::SheetOptions& sheet,
                            OutputFile& file) {
    Workers workers(processors());
    Result<render::Image> image = picture::paint_sheet(frames, look, sheet, workers);
    if (!image) return image;
    if (auto written = render::write_png(*image, file); !written) return tl::unexpected<Error>(written.error());
    if (auto written = file.commit(); !written) return tl::unexpected<Error>(written.error());
    return image;
}

}  // namespace

Result<int> take_shot(const RunOptions& options, const world::World& world, Onlooker& onlooker) {
    const PictureOptions& picture = *options.debug->picture;
    const ShotOptions& shot = std::get<ShotOptions>(picture.of);
    const Result<picture::Look> look = look_of(picture);
    if (!look) return tl::unexpected<Error>(look.error());
    Result<picture::SheetOptions> sheet = sheet_of(picture, world);
    if (!sheet) return tl::unexpected<Error>(sheet.error());
    sheet->columns = static_cast<std::size_t>(shot.columns);
    const Result<std::vector<std::int64_t>> ticks = ticks_of(shot.ticks);
    if (!ticks) return tl::unexpected<Error>(ticks.error());
    // Reserved before the work begins.
    std::optional<OutputFile> file;
    Result<void> opened;
    if (onlooker.speaks())
        opened = OutputFile::open(picture.file, Appears::Whole).map([&](OutputFile&& out) { file.emplace(std::move(out)); });
    if (const auto all = comm::outcome_of_first(onlooker.comm(), opened); !all) return tl::unexpected<Error>(all.error());

    std::vector<picture::Frame> frames(onlooker.speaks() ? ticks->size() : 0);
    for (const std::size_t i : order_of(*ticks, onlooker.at_checkpoint())) {
        if (auto there = onlooker.reach((*ticks)[i]); !there) return tl::unexpected<Error>(there.error());
        Result<picture::Frame> frame = onlooker.look(*look);
        if (!frame) return tl::unexpected<Error>(frame.error());
        if (onlooker.speaks()) frames[i] = std::move(*frame);
    }
    const Result<void> taken = [&]() -> Result<void> {
        if (!onlooker.speaks()) return {};
        onlooker.show([] { return "painting"; });
        return finish_shot(options, frames, *look, *sheet, *file);
    }();
    if (const auto all = comm::outcome_of_first(onlooker.comm(), taken); !all) return tl::unexpected<Error>(all.error());
    return static_cast<int>(ExitCode::Fine);
}

Result<void> finish_shot(const RunOptions& options, std::span<picture::Frame> frames, const picture::Look& look,
                         const picture::SheetOptions& sheet, OutputFile& file) {
    const Result<render::Image> image = paint(frames, look, sheet, file);
    if (!image) return tl::unexpected<Error>(image.error());
    clear_progress();
    return report(options, frames, *image);
}

Result<void> shoot_start(const PictureOptions& picture, const world::World& world, sim::Subdomain& subdomain, record::Drawing& drawing) {
    const Result<picture::Look> look = look_of(picture);
    if (!look) return tl::unexpected<Error>(look.error());
    const Result<picture::SheetOptions> sheet = sheet_of(picture, world);
    if (!sheet) return tl::unexpected<Error>(sheet.error());
    Result<OutputFile> file = OutputFile::open(picture.file, Appears::Whole);
    if (!file) return tl::unexpected<Error>(file.error());
    Result<picture::Frame> frame = picture::look_at(subdomain, drawing, *look);
    if (!frame) return tl::unexpected<Error>(frame.error());
    const Result<render::Image> image = paint({&*frame, 1}, *look, *sheet, *file);
    if (!image) return tl::unexpected<Error>(image.error());
    return print(picture.file == "-" ? stderr : stdout, fmt::format("{}: {} x {} pixels\n", picture.file, image->width, image->height));
}

}  // namespace meld::driver
