#include "runtime/show/view/share/share.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>

#include "runtime/ask/debug/facts.h"
#include "runtime/base/files/output_file.h"
#include "runtime/base/units.h"
#include "runtime/comm/transport/collective_result.h"
#include "runtime/show/picture/palette.h"
#include "runtime/show/view/page/page.h"
#include "runtime/show/view/scene/block.h"
#include "runtime/show/view/share/changes.h"
#include "runtime/show/view/share/pack.h"

namespace meld::view {

namespace {

using nlohmann::ordered_json;

// Frames are compressed together until there is so much of them: the page reads all of it to show one. The first of them is whole; what
// the others change may take as much as that.
constexpr std::size_t kPieceBytes = std::size_t{4} << 20;
constexpr std::size_t kMostFramesInPiece = 128;

// JSON inside of a page: no text of it ends the element that it is in.
std::string in_page(const ordered_json& json) {
    std::string out;
    for (const char c : json.dump(-1, ' ', false, ordered_json::error_handler_t::replace)) {
        if (c == '<')
            out += "\\u003c";
        else
            out += c;
    }
    return out;
}

// The facts of these predicates, as lists in JSON by catom; on process 0. Every process calls it.
Result<FactsOfCatoms> facts_of_catoms(sim::Subdomain& subdomain, const std::vector<std::string>& predicates) {
    std::map<std::uint64_t, ordered_json> lists;
    for (const std::string& name : predicates) {
        const auto found = debug::find_facts(
            subdomain, {.catom = {}, .name = name == "all" ? "" : name, .most_lines = std::numeric_limits<std::uint64_t>::max()});
        if (!found) return tl::unexpected<Error>(found.error());
        for (const std::string& line : found->lines) {
            // "dist(@42, 7)."
            const std::size_t at = line.find("(@");
            std::uint64_t id = 0;
            if (at == std::string::npos || std::from_chars(line.data() + at + 2, line.data() + line.size(), id).ec != std::errc{}) continue;
            ordered_json& list = lists[id];
            if (list.is_null()) list = ordered_json::array();
            list.push_back(line.ends_with('.') ? line.substr(0, line.size() - 1) : line);
        }
    }
    FactsOfCatoms out;
    for (const auto& [id, list] : lists) out.emplace(id, in_page(list));
    return out;
}

// What all frames together say of values, so that a colour means the same in each: a frame with each word, and with so many numbers as are
// kinds, or with the least and the greatest.
class Values {
  public:
    void add(const picture::Frame& frame) {
        if (!frame.coloured_by.empty()) title_ = frame.coloured_by;
        whole_ = whole_ && frame.whole_numbers;
        for (const auto& [at, number] : frame.numbers) {
            low_ = std::min(low_, number);
            high_ = std::max(high_, number);
            if (few_.size() <= kMany) few_.insert(number);
        }
        for (const auto& [at, word] : frame.words) words_.insert(word);
    }
    struct Meaning {
        std::optional<render::Legend> legend = {};
        std::string colours = {};  // Of the numbers asked for, as "rrggbb" each.
    };
    Meaning meaning(const picture::Look& look, const std::vector<render::Number>& numbers) const {
        picture::Frame all{.coloured_by = title_, .whole_numbers = whole_}, asked;
        std::set<render::Number> known = few_;
        if (!known.empty()) known.insert({low_, high_});
        for (const render::Number number : known) all.numbers.emplace_back(all.numbers.size(), number);
        for (const std::string& word : words_) all.words.emplace_back(all.words.size(), word);
        picture::Palette palette(look);
        palette.include(all);
        Meaning out{.legend = palette.settle()};
        for (const render::Number number : numbers) asked.numbers.emplace_back(asked.numbers.size(), number);
        asked.scene.colours.resize(numbers.size());
        palette.apply(asked);
        for (const render::Rgb c : asked.scene.colours) out.colours += fmt::format("{:02x}{:02x}{:02x}", c.r, c.g, c.b);
        return out;
    }

  private:
    static constexpr std::size_t kMany = 64;  // More than are kinds.
    std::string title_;
    bool whole_ = true;
    render::Number low_ = std::numeric_limits<render::Number>::infinity(), high_ = -low_;
    std::set<render::Number> few_;
    std::set<std::string> words_;
};

// The page as it grows, on process 0.
class Page {
  public:
    Page(const ShareOptions& options, OutputFile file) : options_(options), file_(std::move(file)) { put(viewer_page()); }

    Result<void> add(const picture::Frame& frame, FactsOfCatoms facts) {
        values_.add(frame);
        if (changes_.changes_colours(frame))
            if (auto ended = end_piece(); !ended) return ended;
        const bool key = piece_.empty();
        piece_ += changes_.record(frame, std::move(facts), key);
        if (key) most_piece_bytes_ = std::max(kPieceBytes, 2 * piece_.size());
        ticks_.push_back(frame.tick);
        ++frames_in_piece_;
        shared_.catoms = std::max(shared_.catoms, frame.catoms);
        return piece_.size() >= most_piece_bytes_ || frames_in_piece_ >= kMostFramesInPiece ? end_piece() : Result<void>{};
    }

    Result<Shared> finish(const world::World& world, bool flat, const std::string& lattice, const picture::Frame& last) {
        if (auto ended = end_piece(); !ended) return tl::unexpected<Error>(ended.error());
        ordered_json colours = nullptr;
        if (changes_.colours() == Changes::Colours::Numbers) colours = "numbers";
        if (changes_.colours() == Changes::Colours::Words) colours = "words";
        const picture::Look& look = options_.look;
        Values::Meaning meaning = values_.meaning(look, changes_.numbers());
        ordered_json head = {{"version", 1},
                             {"title", options_.title},
                             {"lattice", lattice},
                             {"flat", flat},
                             {"bodies", world.is_free()},
                             {"form", static_cast<int>(last.scene.form)},
                             {"catoms", shared_.catoms},
                             {"ticks", ticks_},
                             {"pieces", pieces_},
                             {"colours", std::move(colours)},
                             {"words", changes_.words()},
                             {"legend", legend_json(meaning.legend)},
                             {"exact", std::move(meaning.colours)},
                             {"facts", options_.facts},
                             {"compounds", compounds_json(last.scene)},
                             {"lamps", lamps_json(last.scene)},
                             {"look",
                              {{"colour", look.colour},
                               {"only", look.only},
                               {"hide", look.hide},
                               {"links", look.links},
                               {"arrows", look.arrows},
                               {"labels", look.labels},
                               {"exposed", look.exposed}}}};
        put("<script type=\"application/json\" id=\"share\">" + in_page(head) + "</script>\n");
        if (auto done = file_.commit(); !done) return tl::unexpected<Error>(done.error());
        shared_.frames = ticks_.size();
        shared_.first = ticks_.front();
        shared_.last = ticks_.back();
        return shared_;
    }

  private:
    void put(std::string_view text) {
        shared_.bytes += text.size();
        file_.write(text);
    }

    Result<void> end_piece() {
        if (frames_in_piece_ == 0) return {};
        const std::string letters = base64(deflated(piece_));
        if (shared_.bytes + letters.size() > options_.most_bytes)
            return fail(fmt::format("{} would have more than {} MB with the frame of tick {}", options_.file,
                                    options_.most_bytes / 1'000'000, ticks_.back()),
                        "Share fewer ticks (--ticks, --every), fewer facts (--facts), fewer catoms (--only, --exposed), or raise --limit",
                        ExitCode::LimitHit);
        put(fmt::format("<script type=\"text/plain\" id=\"piece{}\">{}</script>\n", pieces_.size(), letters));
        pieces_.push_back(frames_in_piece_);
        frames_in_piece_ = 0;
        piece_.clear();
        return {};
    }

    const ShareOptions& options_;
    OutputFile file_;
    Changes changes_;
    Values values_;
    std::string piece_;
    std::size_t frames_in_piece_ = 0, most_piece_bytes_ = kPieceBytes;
    std::vector<std::size_t> pieces_;  // The frames in each.
    std::vector<std::int64_t> ticks_;
    Shared shared_;
};

}  // namespace

Result<Shared> write_share(timeline::Timeline& timeline, const world::World& world, const std::function<record::Drawing&()>& drawing,
                           const ShareOptions& options, const std::function<void(std::int64_t tick)>& frame_made) {
    const auto subdomain = [&]() -> sim::Subdomain& { return timeline.simulation().subdomain(); };
    comm::Communicator& comm = subdomain().comm;
    std::optional<Page> page;
    Result<void> opened;
    if (comm.process() == 0)
        opened = OutputFile::open(options.file, Appears::Whole).map([&](OutputFile&& file) { page.emplace(options, std::move(file)); });
    if (const auto all = comm::outcome_of_first(comm, opened); !all) return tl::unexpected<Error>(all.error());
    picture::Frame last;
    while (true) {
        Result<picture::Frame> frame = picture::look_at(subdomain(), drawing(), options.look);
        if (!frame) return tl::unexpected<Error>(frame.error());
        Result<FactsOfCatoms> facts = facts_of_catoms(subdomain(), options.facts);
        if (!facts) return tl::unexpected<Error>(facts.error());
        const Result<void> added = page ? page->add(*frame, std::move(*facts)) : Result<void>{};
        if (const auto all = comm::outcome_of_first(comm, added); !all) return tl::unexpected<Error>(all.error());
        last = std::move(*frame);
        if (frame_made) frame_made(timeline.tick());
        const std::int64_t now = timeline.tick();
        if (options.last >= 0 && now >= options.last) break;
        // The last frame is that of the last tick, wherever the others are.
        const std::int64_t next = now + options.every;
        if (auto there = timeline.to(options.last >= 0 ? std::min(next, options.last) : next); !there)
            return tl::unexpected<Error>(there.error());
        if (timeline.ended() == sim::Ending::Interrupted)
            return fail(fmt::format("interrupted after tick {}", timeline.tick()), "", ExitCode::Interrupted);
        if (timeline.tick() == now) break;
    }
    Result<Shared> shared;
    if (page) {
        const world::Lattice& lattice = subdomain().lattice;
        shared =
            page->finish(world, lattice.flat() && !world.is_free(), world.is_free() ? "bodies" : std::string(world.lattice_name()), last);
    }
    if (const auto all = comm::outcome_of_first(comm, shared.map([](const Shared&) {})); !all) return tl::unexpected<Error>(all.error());
    return shared;
}

}  // namespace meld::view
