// Where the camera is during a film.
#pragma once

#include <cstdint>
#include <vector>

#include "runtime/show/render/camera.h"

namespace meld::picture {

class CameraPath {
  public:
    // Where the camera is after a tick.
    struct Key {
        std::int64_t tick = 0;
        double azimuth_deg = 0, elevation_deg = 0, zoom = 1;
    };

    // From this view, around the scene by so many degrees during the film; 0: it stays.
    CameraPath(const render::View& view, double turn_deg) : view_(view), turn_deg_(turn_deg) {}
    // Through these keys, which are in the order of their ticks, each with another; the angle of view is that of `view`. Between two keys
    // it moves smoothly and never beyond either, and before the first and after the last it stays.
    CameraPath(const render::View& view, std::vector<Key> keys) : view_(view), keys_(std::move(keys)) {}

    bool moves() const { return turn_deg_ != 0 || keys_.size() > 1; }
    // In a frame of so many, which shows this tick. A whole turn does not end where it began, so that the film can go round and round.
    render::View at(std::int64_t tick, std::size_t frame, std::size_t frames) const;

  private:
    render::View view_;
    double turn_deg_ = 0;
    std::vector<Key> keys_ = {};
};

}  // namespace meld::picture
