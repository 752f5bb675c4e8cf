// Frames of one run for pages: made from the whole state of the run, or from the frame before and what has changed since.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>

#include "runtime/base/error.h"
#include "runtime/results/record/drawing.h"
#include "runtime/results/timeline/timeline.h"
#include "runtime/show/picture/frame.h"
#include "runtime/show/view/kept/kept_frame.h"
#include "runtime/show/view/reply.h"

namespace meld::view {

struct FrameRequest {
    std::string text = {};  // All that it depends on but the state of the run: equal texts ask for the same.
    picture::Look look = {};
    std::size_t most = 0;  // Catoms that are sent.
    bool with_values = false;
};

class Frames {
  public:
    // The frame of the run as it is; on process 0, an empty one on the others. Every process calls it with the same requests, between two
    // ticks. `changes` is another number whenever the run is elsewhere or was changed. Errors: those of picture::look_at().
    // Cost: nothing if the run has not changed. Else what KeptFrame says, if such a frame is kept and the page's last one was like it; else
    // a look at all catoms.
    Result<Reply> make(const FrameRequest& request, timeline::Timeline& timeline, record::Drawing& drawing, std::uint64_t changes);

  private:
    struct Kept {
        FrameRequest request = {};
        bool made = false;           // There is a reply.
        std::uint64_t used = 0;      // When it was asked for last.
        std::uint64_t replaced = 0;  // As of the timeline: in which run it was made,
        std::uint64_t changes = 0;   // and of which state of it.
        bool tried = false;          // Whether such a frame can be kept has been tried in this run.
        std::unique_ptr<KeptFrame> frame = {};
        sim::Touched* touched = nullptr;  // The subdomain's.
        Reply reply = {};
    };
    Kept& kept_for(const FrameRequest& request, std::uint64_t replaced);
    static Result<void> update(Kept& kept, sim::Subdomain& subdomain, record::Drawing& drawing);
    static Result<bool> update_kept(Kept& kept, sim::Subdomain& subdomain, record::Drawing& drawing);

    // Pages that look at the same have one frame. Each takes memory, so there are only two.
    std::array<Kept, 2> all_;
    std::uint64_t asked_ = 0;
};

}  // namespace meld::view
