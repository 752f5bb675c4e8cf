#include "runtime/show/view/frames.h"

#include <algorithm>
#include <cstring>
#include <functional>
#include <optional>
#include <span>
#include <utility>

#include "runtime/show/view/scene/block.h"
#include "runtime/show/view/scene/thin.h"

namespace meld::view {

namespace {

// `thinned` leaves catoms of the frame out.
Reply reply_of(picture::Frame& frame, const std::optional<render::Legend>& legend, std::size_t shown, bool with_values,
               const std::function<Thinned(picture::Frame&)>& thinned) {
    Reply reply{.words = frame_words(frame, legend)};
    reply.words["shown"] = shown;
    const Thinned how = thinned(frame);
    reply.words["mistakes"] = as_page_says_them(frame.mistakes);
    reply.words["sent"] = frame.ids.size();
    reply.words["coarse"] = how.coarse;
    const Values values = with_values ? values_of(frame) : Values{};
    if (!values.names.empty()) reply.words["names"] = values.names;
    reply.binary = frame_block(frame, how.covers, values);
    return reply;
}

// The same frame after another tick.
void set_tick(Reply& reply, std::int64_t tick) {
    reply.words["tick"] = tick;
    std::memcpy(reply.binary.data() + kBlockTick, &tick, sizeof tick);
}

Result<Reply> whole_frame(const FrameRequest& request, sim::Subdomain& subdomain, record::Drawing& drawing) {
    Result<picture::Frame> seen = picture::look_at(subdomain, drawing, request.look);
    if (!seen) return tl::unexpected<Error>(as_page_says_it(seen.error()));
    if (subdomain.comm.process() != 0) return Reply{};
    const std::optional<render::Legend> legend = picture::colour(std::span(&*seen, 1), request.look);
    return reply_of(*seen, legend, seen->ids.size(), request.with_values, [&](picture::Frame& frame) { return thin(frame, request.most); });
}

}  // namespace

// The one that is like this request; or the one that was not asked for for the longest time, for this request now.
Frames::Kept& Frames::kept_for(const FrameRequest& request, std::uint64_t replaced) {
    auto found = std::ranges::find_if(all_, [&](const Kept& kept) { return kept.used > 0 && kept.request.text == request.text; });
    if (found == all_.end()) {
        found = std::ranges::min_element(all_, {}, &Kept::used);
        // The frame has a look that is no more.
        found->frame.reset();
        found->request = request;
        found->tried = found->made = false;
    }
    if (found->replaced != replaced) {
        found->frame.reset();
        found->touched = nullptr;
        found->tried = found->made = false;
        found->replaced = replaced;
    }
    found->used = ++asked_;
    return *found;
}

Result<Reply> Frames::make(const FrameRequest& request, timeline::Timeline& timeline, record::Drawing& drawing, std::uint64_t changes) {
    Kept& kept = kept_for(request, timeline.replaced());
    if (kept.made && kept.changes == changes) return kept.reply;
    if (auto done = update(kept, timeline.simulation().subdomain(), drawing); !done) return tl::unexpected<Error>(done.error());
    kept.changes = changes;
    return kept.reply;
}

Result<void> Frames::update(Kept& kept, sim::Subdomain& subdomain, record::Drawing& drawing) {
    const Result<bool> updated = update_kept(kept, subdomain, drawing);
    kept.made = updated.has_value();
    if (!updated) return tl::unexpected<Error>(updated.error());
    if (*updated) return {};
    Result<Reply> whole = whole_frame(kept.request, subdomain, drawing);
    kept.made = whole.has_value();
    if (!whole) return tl::unexpected<Error>(whole.error());
    kept.reply = std::move(*whole);
    return {};
}

// Returns whether the reply is that of a frame that is kept.
Result<bool> Frames::update_kept(Kept& kept, sim::Subdomain& subdomain, record::Drawing& drawing) {
    const FrameRequest& request = kept.request;
    if (!std::exchange(kept.tried, true)) {
        kept.frame = KeptFrame::make(subdomain, drawing, request.look, request.most);
        if (kept.frame && kept.touched == nullptr) kept.touched = &subdomain.follow();
        if (kept.frame) kept.touched->add_all();
    }
    if (!kept.frame) return false;
    const Result<KeptFrame::Updated> updated = kept.frame->update(subdomain, drawing, *kept.touched);
    if (!updated || *updated == KeptFrame::Updated::TooWide) kept.frame.reset();
    if (!updated) {
        kept.tried = false;
        return tl::unexpected<Error>(updated.error());
    }
    if (!kept.frame) return false;
    if (subdomain.comm.process() != 0) return true;
    if (kept.made && *updated == KeptFrame::Updated::Same) {
        set_tick(kept.reply, subdomain.tick());
        return true;
    }
    KeptFrame::Seen seen = kept.frame->seen(subdomain.tick());
    kept.reply =
        reply_of(seen.frame, seen.legend, seen.shown, request.with_values, [&](picture::Frame& frame) { return kept.frame->thin(frame); });
    return true;
}

}  // namespace meld::view
