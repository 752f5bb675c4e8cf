// What colours mean in one frame or in many: the values that there are, and the colour of each.
#pragma once

#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "runtime/show/picture/frame.h"
#include "runtime/show/render/caption.h"

namespace meld::picture {

class Palette {
  public:
    // Of the values that look.colour asks for; without it, of those of lines and arrows. `look` must outlive it.
    explicit Palette(const Look& look) : look_(look) {}

    // The values of a frame are to have colours. Memory: the words that differ.
    void include(const Frame& frame);
    // What is told of them; nothing if there are none, or no colours were asked for. Colours mean this from now on.
    std::optional<render::Legend> settle();
    // Gives the catoms of a frame that was included the colours of their values; those without one are grey, whatever they have given
    // themselves. Or gives lines and arrows those of theirs. After settle(); any thread may call it.
    void apply(Frame& frame) const;

  private:
    render::Rgb of_number(render::Number number) const;
    void colour_few();
    render::Legend of_words() const;
    render::Legend of_numbers() const;

    const Look& look_;
    std::string title_ = {};
    bool any_ = false, whole_numbers_ = true;
    render::Number low_ = std::numeric_limits<render::Number>::infinity(), high_ = -low_;
    std::set<render::Number> few_ = {};                       // The numbers, while they are few.
    std::map<render::Number, render::Rgb> few_colours_ = {};  // If each has a colour and a line in the legend.
    std::map<std::string, render::Rgb> kinds_ = {};
};

}  // namespace meld::picture
