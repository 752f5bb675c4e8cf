// The frames of a film, wherever they come from: first each is measured, then each is painted and goes into the file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/driver/pictures/picture_options.h"
#include "runtime/driver/setup/options.h"
#include "runtime/show/picture/film.h"
#include "runtime/show/picture/film_file.h"

namespace meld::driver {

class Reel {
  public:
    // How far the work is, where that is shown.
    using Show = std::function<void(const std::function<std::string()>&)>;
    // All must outlive it.
    Reel(const RunOptions& options, const picture::Look& look, const picture::SheetOptions& sheet, const MovieOrders& orders, Show show);

    void measure(const picture::Frame& frame);
    // After the last frame has been measured. Errors: there is no room for what is in them.
    Result<void> settle() { return film_.settle(); }
    // Errors: the file cannot be written.
    Result<void> open();
    // A frame that was measured, in the order in which it was. It is painted with the next ones, or now. Errors: a signal has asked for
    // the end (130); it cannot be painted or written (4).
    Result<void> take(picture::Frame frame, bool last);
    // After the last frame, or after a signal has come: makes the film whole. Returns how it went, which was `done` so far.
    Result<void> end(const Result<void>& done);
    // Prints what the film is.
    Result<void> report() const;

  private:
    // A picture that is to be painted.
    struct Shown {
        picture::Frame frame;
        std::size_t number = 0, repeats = 1;  // The first of its pictures, and how many show this frame.
    };

    Result<void> paint_waiting();
    std::size_t held() const;
    std::size_t count() const { return ticks_.size() + held(); }
    // How many frames are painted side by side.
    std::size_t together() const;

    const RunOptions& options_;
    const PictureOptions& picture_;
    const MovieOptions& movie_;
    const picture::SheetOptions& sheet_;
    Show show_;
    picture::Film film_;
    std::vector<std::int64_t> ticks_ = {};       // Of the frames.
    std::uint64_t most_shown_ = 0, catoms_ = 0;  // In a frame.
    std::unique_ptr<picture::FilmFile> file_ = {};
    std::vector<Shown> waiting_ = {};
    std::size_t painted_ = 0;
};

// How many frames there is room for in a film of so many seconds.
std::int64_t most_frames(const MovieOptions& movie, double seconds);

}  // namespace meld::driver
