#include "runtime/show/render/caption.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "runtime/show/render/callouts.h"
#include "runtime/show/render/surface.h"

namespace meld::render {

namespace {

// Sizes in heights of a letter.
constexpr double kGap = 0.7, kBar = 1.0, kLine = 1.5, kBorder = 1.2;
constexpr double kTitle = 1.35;         // Of a title's letters.
constexpr std::size_t kMostKinds = 20;  // Of a legend; the others are counted.
constexpr double kLongestScale = 0.2;   // Of the width of the picture.
constexpr double kWidestCallout = 0.3;  // Of the same.

double letter_of(std::size_t width, std::size_t height) {
    return std::clamp(static_cast<double>(std::min(width, 2 * height)) / 60, 9.0, 60.0);
}

// Writes and measures on a picture, or measures only.
class Writer {
  public:
    Writer(const Surface& surface, double letter) : pen_(pen_for(surface)), letter_(letter) {
        cairo_select_font_face(pen_.get(), "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
        // Letters are not moved to whole pixels: a text in letters of half the size is half as wide.
        cairo_font_options_t* const options = cairo_font_options_create();
        cairo_font_options_set_hint_metrics(options, CAIRO_HINT_METRICS_OFF);
        cairo_set_font_options(pen_.get(), options);
        cairo_font_options_destroy(options);
        size(1);
    }
    cairo_t* pen() const { return pen_.get(); }
    double letter() const { return letter_; }
    void size(double factor) { cairo_set_font_size(pen_.get(), factor * letter_); }
    void ink(Rgb c, double alpha = 1) { cairo_set_source_rgba(pen_.get(), c.r / 255.0, c.g / 255.0, c.b / 255.0, alpha); }
    double width(const std::string& text) const {
        cairo_text_extents_t extents;
        cairo_text_extents(pen_.get(), text.c_str(), &extents);
        return extents.x_advance;
    }
    // With the left end of its base line there.
    void write(double x, double y, const std::string& text) {
        cairo_move_to(pen_.get(), x, y);
        cairo_show_text(pen_.get(), text.c_str());
    }
    void box(double x, double y, double width, double height) {
        cairo_rectangle(pen_.get(), x, y, width, height);
        cairo_fill(pen_.get());
    }

  private:
    Pen pen_;
    double letter_;
};

// A picture that is only there so that letters can be measured.
struct Nowhere {
    Image image{.width = 1, .height = 1, .pixels = {0}};
    Surface surface = surface_of(image);
};

// 1, 2 or 5 times a power of ten, at least so large.
double round_step(double least) {
    const double power = std::pow(10, std::floor(std::log10(least)));
    for (const double factor : {1.0, 2.0, 5.0})
        if (factor * power >= least * (1 - 1e-9)) return factor * power;
    return 10 * power;
}

std::string number(Number x, int digits = 6) { return fmt::format("{:.{}g}", std::abs(x) < 1e-12L ? 0.0L : x, digits); }

struct Mark {
    Number at = 0;
    std::string text = {};
};

// The numbers beside a scale: of six digits, or as many as it takes to tell them apart.
std::vector<Mark> marks(const Legend::Scale& scale) {
    std::vector<Mark> out;
    if (scale.high > scale.low) {
        double step = round_step(static_cast<double>((scale.high - scale.low) / 6));
        if (scale.whole) step = std::max(step, 1.0);
        for (Number at = std::ceil(scale.low / step - 1e-9L); at * step <= scale.high + 1e-9L * step; ++at) out.push_back({at * step});
    } else {
        out.push_back({scale.low});
    }
    for (int digits = 6; digits <= std::numeric_limits<Number>::max_digits10; ++digits) {
        for (Mark& mark : out) mark.text = number(mark.at, digits);
        if (std::ranges::adjacent_find(out, {}, &Mark::text) == out.end()) break;
    }
    return out;
}

std::vector<std::string> words_of(const Legend& legend) {
    std::vector<std::string> out;
    if (legend.scale)
        for (const Mark& mark : marks(*legend.scale)) out.push_back(mark.text);
    for (std::size_t i = 0; i < std::min(legend.kinds.size(), kMostKinds); ++i) out.push_back(legend.kinds[i].first);
    if (legend.kinds.size() > kMostKinds) out.push_back(fmt::format("and {} more", legend.kinds.size() - kMostKinds));
    return out;
}

double legend_width(const Writer& writer, const Legend& legend) {
    double widest = 0;
    for (const std::string& text : words_of(legend)) widest = std::max(widest, (kBar + kGap) * writer.letter() + writer.width(text));
    return std::max(widest, writer.width(legend.title));
}

void write_scale(Writer& writer, const Legend::Scale& scale, double x, double top, double height, Rgb ink) {
    const double letter = writer.letter();
    const int steps = static_cast<int>(height);
    for (int i = 0; i < steps; ++i) {
        writer.ink(scale.map.at(1 - (i + 0.5) / steps));
        writer.box(x, top + i, kBar * letter, 1.5);
    }
    writer.ink(ink);
    const Number range = scale.high - scale.low;
    for (const Mark& mark : marks(scale)) {
        const double y = top + height * (range > 0 ? static_cast<double>(1 - (mark.at - scale.low) / range) : 0.5);
        writer.box(x + kBar * letter, y - 0.5, 0.3 * kGap * letter, 1);
        writer.write(x + (kBar + kGap) * letter, y + 0.35 * letter, mark.text);
    }
}

void write_kinds(Writer& writer, const Legend& legend, double x, double top, Rgb ink) {
    const double letter = writer.letter();
    const std::vector<std::string> words = words_of(legend);
    for (std::size_t i = 0; i < words.size(); ++i) {
        const double y = top + static_cast<double>(i) * kLine * letter;
        if (i < kMostKinds) {
            writer.ink(legend.kinds[i].second);
            writer.box(x, y, kBar * letter, kBar * letter);
        }
        writer.ink(ink);
        writer.write(x + (kBar + kGap) * letter, y + 0.85 * letter, words[i]);
    }
}

void write_legend(Writer& writer, const Legend& legend, const Image& image, Rgb ink) {
    const double letter = writer.letter(), picture = static_cast<double>(image.height);
    const double x = static_cast<double>(image.width) - kBorder * letter - legend_width(writer, legend);
    const double height =
        legend.scale ? std::max(0.45 * picture, 4 * letter) : kLine * letter * static_cast<double>(words_of(legend).size());
    const double top = std::max((picture - height) / 2, 2 * kLine * letter);
    writer.ink(ink);
    writer.write(x, top - 0.8 * letter, legend.title);
    if (legend.scale)
        write_scale(writer, *legend.scale, x, top, height, ink);
    else
        write_kinds(writer, legend, x, top, ink);
}

std::string length_in_metres(double metres) {
    if (metres >= 1) return number(metres) + " m";
    if (metres >= 1e-3) return number(metres * 1e3) + " mm";
    return number(metres * 1e6) + " µm";
}

void write_length(Writer& writer, const Caption& caption, const Camera& camera, const Image& image) {
    const double letter = writer.letter(), most = kLongestScale * static_cast<double>(image.width) / static_cast<double>(camera.scale());
    const double unit = caption.catom_metres.value_or(1);
    // The longest round length that is not too long.
    double length = round_step(most * unit / 2.5);
    while (round_step(length * 1.5) <= most * unit) length = round_step(length * 1.5);
    const double pixels = length / unit * static_cast<double>(camera.scale());
    const std::string text = caption.catom_metres ? length_in_metres(length) : number(length) + (length == 1 ? " catom" : " catoms");
    const double right = static_cast<double>(image.width) - kBorder * letter, y = static_cast<double>(image.height) - kBorder * letter;
    writer.ink(caption.ink);
    writer.box(right - pixels, y - 2, pixels, 2);
    writer.box(right - pixels, y - 0.4 * letter, 1.5, 0.4 * letter);
    writer.box(right - 1.5, y - 0.4 * letter, 1.5, 0.4 * letter);
    writer.write(right - (pixels + writer.width(text)) / 2, y - 0.7 * letter, text);
}

void write_notes(Writer& writer, const Painted& picture, const Scene& scene, const Camera& camera, Rgb ink) {
    const Image& image = picture.image;
    for (const Note& note : scene.notes) {
        const Camera::Pixel at = camera.project(note.at);
        if (!(at.x >= 0 && at.y >= 0 && at.x < static_cast<float>(image.width) && at.y < static_cast<float>(image.height))) continue;
        const std::size_t pixel = static_cast<std::size_t>(at.y) * image.width + static_cast<std::size_t>(at.x);
        if (picture.distances[pixel] < at.distance - 1.2F) continue;
        const double x = at.x - writer.width(note.text) / 2, y = at.y + 0.35 * writer.letter();
        // Readable on any colour.
        cairo_move_to(writer.pen(), x, y);
        cairo_text_path(writer.pen(), note.text.c_str());
        writer.ink(brightness(ink) < 0.5 ? Rgb{255, 255, 255} : Rgb{0, 0, 0}, 0.75);
        cairo_set_line_width(writer.pen(), 0.25 * writer.letter());
        cairo_set_line_join(writer.pen(), CAIRO_LINE_JOIN_ROUND);
        cairo_stroke_preserve(writer.pen());
        writer.ink(ink);
        cairo_fill(writer.pen());
    }
}

// With at most this width: what is too much of it is replaced by an ellipsis.
std::string shortened(const Writer& writer, std::string text, double width) {
    if (writer.width(text) <= width) return text;
    while (!text.empty() && writer.width(text + "…") > width) {
        // A whole letter, which may have several bytes.
        while (!text.empty() && (static_cast<unsigned char>(text.back()) & 0xc0) == 0x80) text.pop_back();
        if (!text.empty()) text.pop_back();
    }
    return text + "…";
}

double callout_width(double letters, double letter, double picture) {
    return std::min(letters * letter, kWidestCallout * picture - (kBorder + kGap) * letter);
}

// Where labels beside a picture stand.
Columns callout_columns(double letters, double letter, const Image& image) {
    const double width = static_cast<double>(image.width), height = static_cast<double>(image.height);
    const double text = callout_width(letters, letter, width) + (kBorder + kGap / 2) * letter;
    return {.left = text, .right = width - text, .top = 4 * letter, .bottom = height - 4 * letter, .step = kLine * letter};
}

void draw_line(Writer& writer, const Anchor& from, const Anchor& to, Rgb ink, bool hidden) {
    cairo_t* const pen = writer.pen();
    const double width = std::max(0.09 * writer.letter(), 1.0), dot = 0.22 * writer.letter();
    const Rgb paper = brightness(ink) < 0.5 ? Rgb{255, 255, 255} : Rgb{0, 0, 0};
    // First something paler and wider, so that it is seen on any colour.
    for (const bool halo : {true, false}) {
        writer.ink(halo ? paper : ink, halo ? 0.7 : 1);
        cairo_set_line_width(pen, halo ? 3 * width : width);
        const double dashes[] = {4 * width, 3 * width};
        cairo_set_dash(pen, dashes, hidden && !halo ? 2 : 0, 0);
        cairo_move_to(pen, from.x, from.y);
        cairo_line_to(pen, to.x, to.y);
        cairo_stroke(pen);
        cairo_set_dash(pen, dashes, 0, 0);
        cairo_arc(pen, from.x, from.y, halo ? 1.6 * dot : dot, 0, 6.2832);
        if (hidden && !halo)
            cairo_stroke(pen);
        else
            cairo_fill(pen);
    }
}

void write_callouts(Writer& writer, const Painted& picture, const Scene& scene, const Camera& camera, const Caption& caption) {
    const Image& image = picture.image;
    std::vector<Anchor> anchors;
    std::vector<const Note*> notes;
    std::vector<bool> hidden;
    for (const Note& note : scene.callouts) {
        const Camera::Pixel at = camera.project(note.at);
        if (!(at.x >= 0 && at.y >= 0 && at.x < static_cast<float>(image.width) && at.y < static_cast<float>(image.height))) continue;
        anchors.push_back({at.x, at.y});
        notes.push_back(&note);
        hidden.push_back(picture.distances[static_cast<std::size_t>(at.y) * image.width + static_cast<std::size_t>(at.x)] <
                         at.distance - 1.2F);
    }
    const double letter = writer.letter(), gap = 0.3 * letter;
    const Columns columns = callout_columns(caption.callouts, letter, image);
    const std::vector<Label> labels = place_labels(anchors, columns);
    for (std::size_t i = 0; i < labels.size(); ++i)
        draw_line(writer, anchors[i], {labels[i].right ? columns.right : columns.left, labels[i].y}, caption.ink, hidden[i]);
    writer.ink(caption.ink);
    const double width = callout_width(caption.callouts, letter, static_cast<double>(image.width));
    for (std::size_t i = 0; i < labels.size(); ++i) {
        const std::string text = shortened(writer, notes[i]->text, width);
        writer.write(labels[i].right ? columns.right + gap : columns.left - gap - writer.width(text), labels[i].y + 0.35 * letter, text);
    }
}

}  // namespace

double letters_wide(const std::string& text) {
    constexpr double kSize = 100, kRounded = 1.01;
    const Nowhere nowhere;
    return kRounded * Writer(nowhere.surface, kSize).width(text) / kSize;
}

std::size_t room_for_callouts(std::size_t width, std::size_t height) {
    return 2 * callout_columns(0, letter_of(width, height), {.width = width, .height = height, .pixels = {}}).capacity();
}

Margins margins(const Caption& caption, std::size_t width, std::size_t height) {
    const Nowhere nowhere;
    const Writer writer(nowhere.surface, letter_of(width, height));
    const double letter = writer.letter();
    const auto part = [](double pixels, std::size_t of) { return static_cast<float>(std::min(pixels / static_cast<double>(of), 0.4)); };
    Margins out;
    if (!caption.title.empty()) out.top = std::max(out.top, part((kBorder + kTitle + kGap) * letter, height));
    if (!caption.line.empty() || caption.scale) out.bottom = std::max(out.bottom, part((2 * kBorder + kGap) * letter, height));
    if (caption.legend) out.right = std::max(out.right, part((kBorder + kGap) * letter + legend_width(writer, *caption.legend), width));
    if (caption.callouts > 0)
        for (float* side : {&out.left, &out.right})
            *side = std::max(
                *side, part((kBorder + 2 * kGap) * letter + callout_width(caption.callouts, letter, static_cast<double>(width)), width));
    return out;
}

void write_over(Painted& picture, const Scene& scene, const Camera& camera, const Caption& caption) {
    const Surface surface = surface_of(picture.image);
    Writer writer(surface, letter_of(picture.image.width, picture.image.height));
    const double letter = writer.letter();
    write_notes(writer, picture, scene, camera, caption.ink);
    if (!scene.callouts.empty()) write_callouts(writer, picture, scene, camera, caption);
    if (caption.legend) write_legend(writer, *caption.legend, picture.image, caption.ink);
    if (caption.scale) write_length(writer, caption, camera, picture.image);
    writer.ink(caption.ink);
    writer.write(kBorder * letter, static_cast<double>(picture.image.height) - kBorder * letter, caption.line);
    writer.size(kTitle);
    writer.write(kBorder * letter, (kBorder + 0.8 * kTitle) * letter, caption.title);
}

}  // namespace meld::render
