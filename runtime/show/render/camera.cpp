#include "runtime/show/render/camera.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace meld::render {

namespace {

constexpr float kNone = std::numeric_limits<float>::infinity();

float radians(float degrees) { return degrees * std::numbers::pi_v<float> / 180; }

}  // namespace

Camera::Camera(const View& view, std::size_t width, std::size_t height, Margins margins)
    : aspect_(static_cast<float>(width) / static_cast<float>(height)),
      zoom_(view.zoom),
      width_(width),
      height_(height),
      left_(1 - 2 * margins.left),
      right_edge_(1 - 2 * margins.right),
      top_(1 - 2 * margins.top),
      bottom_(1 - 2 * margins.bottom),
      low_(kNone, kNone, kNone),
      high_(-kNone, -kNone, -kNone),
      most_(-kNone, -kNone),
      least_(kNone, kNone) {
    const float turn = radians(view.azimuth_deg), tilt = radians(view.elevation_deg);
    forward_ = -Vec(std::cos(turn) * std::cos(tilt), std::sin(turn) * std::cos(tilt), std::sin(tilt));
    right_ = Vec(-std::sin(turn), std::cos(turn), 0);
    up_ = right_.cross(forward_);
    tangent_ = std::tan(radians(view.angle_deg) / 2);
}

void Camera::include(const Scene& scene) {
    // Of the planes through the left, right, lower and upper edge.
    const Eigen::Array2f low_slope = Eigen::Array2f(left_ * aspect_, bottom_) * tangent_;
    const Eigen::Array2f high_slope = Eigen::Array2f(right_edge_ * aspect_, top_) * tangent_;
    const Eigen::Array2f low_length = (1 + low_slope.square()).sqrt(), high_length = (1 + high_slope.square()).sqrt();
    const auto take = [&](const Vec& place, float radius) {
        const Eigen::Array3f at(place.dot(right_), place.dot(up_), place.dot(forward_));
        low_ = low_.min(at - radius);
        high_ = high_.max(at + radius);
        most_ = most_.max(at.head<2>() - high_slope * at.z() + high_length * radius);
        least_ = least_.min(at.head<2>() + low_slope * at.z() - low_length * radius);
        any_ = true;
    };
    for (std::size_t i = 0; i < scene.places.size(); ++i) take(scene.places[i], scene.reach(i));
    for (const Stroke& stroke : scene.strokes)
        for (const Vec* end : {&stroke.from, &stroke.to}) take(*end, stroke.radius);
}

void Camera::fit() {
    if (!any_) include({.places = {Vec::Zero()}, .diameters = {10}});
    const Eigen::Array2f low_part(left_ * aspect_, bottom_), high_part(right_edge_ * aspect_, top_);
    const float middle = (low_.z() + high_.z()) / 2;
    Eigen::Array2f at;
    float depth = 0;
    if (tangent_ == 0) {
        half_height_ = ((high_ - low_).head<2>() / (low_part + high_part)).maxCoeff();
        // The middle of what is free, not of the picture.
        at = (low_ + high_).head<2>() / 2 - half_height_ * (high_part - low_part) / 2;
        depth = low_.z() - 1;
    } else {
        // From there backwards everything is between the planes; nearer it is not.
        depth = ((least_ - most_) / ((low_part + high_part) * tangent_)).minCoeff();
        at = ((most_ + high_part * tangent_ * depth) + (least_ - low_part * tangent_ * depth)) / 2;
        half_height_ = tangent_ * (middle - depth);
    }
    half_height_ /= zoom_;
    eye_ = at.x() * right_ + at.y() * up_ + depth * forward_;
}

void Camera::aim(const Aim& at) {
    half_height_ = at.half_height;
    zoom_ = 1;
    const float middle = at.target.dot(forward_);
    const float depth = tangent_ == 0 ? std::min(any_ ? low_.z() : middle, middle) - 1 : middle - half_height_ / tangent_;
    eye_ = at.target + (depth - middle) * forward_;
}

Camera::Ray Camera::ray(float x, float y) const {
    const float u = (2 * x / static_cast<float>(width_) - 1) * aspect_, v = 1 - 2 * y / static_cast<float>(height_);
    if (tangent_ == 0) return {eye_ + half_height_ * (u * right_ + v * up_), forward_};
    return {eye_, (forward_ + tangent_ / zoom_ * (u * right_ + v * up_)).normalized()};
}

Camera::Pixel Camera::project(const Vec& at) const {
    const Vec away = at - eye_;
    const float depth = away.dot(forward_), half = tangent_ == 0 ? half_height_ : tangent_ / zoom_ * depth;
    return {(away.dot(right_) / (half * aspect_) + 1) / 2 * static_cast<float>(width_),
            (1 - away.dot(up_) / half) / 2 * static_cast<float>(height_), tangent_ == 0 ? depth : away.norm()};
}

}  // namespace meld::render
