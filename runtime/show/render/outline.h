// What of many scenes a camera must leave room for, in little memory: the outermost things in the directions that matter to it.
#pragma once

#include <vector>

#include "runtime/show/render/camera.h"
#include "runtime/show/render/scene.h"

namespace meld::render {

class Outline {
  public:
    // For a camera that stays where it is, of a picture of about this shape (width by height). What Camera::fit() makes of it is what it
    // would make of all the scenes, but for less than a thousandth.
    Outline(const View& view, float aspect);
    // For a camera that moves around: all is taken to be in one ball, so that the ensemble stays as large as it is from each side.
    static Outline from_all_sides();

    // Cost: some 40 ns a catom.
    void include(const Scene& scene);
    // A scene in place of all that were included; empty: none had anything in it.
    Scene scene() const;

  private:
    Outline() = default;
    struct Extreme {
        Vec direction;
        float reach = -1;  // Of the ball along the direction.
        Vec at = Vec::Zero();
        float radius = -1;  // Negative: there is none yet.
    };
    std::vector<Extreme> extremes_;
    bool as_ball_ = false;
};

}  // namespace meld::render
