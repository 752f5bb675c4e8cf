// From where a scene is seen.
#pragma once

#include <cstddef>
#include <span>

#include "runtime/show/render/scene.h"

namespace meld::render {

struct View {
    float azimuth_deg = -60;  // Of the camera around the scene, from the x axis towards the y axis.
    float elevation_deg = 25;
    float zoom = 1;        // How much larger than what fits.
    float angle_deg = 25;  // Across the height of the picture; 0: parallel rays.
};

// What is in the middle of a picture, and how far it reaches from there to its upper edge.
struct Aim {
    Vec target = Vec::Zero();
    float half_height = 1;
};

// Fractions of a picture that are kept free.
struct Margins {
    float left = 0, right = 0, top = 0, bottom = 0;
};

class Camera {
  public:
    // A picture of so many pixels.
    Camera(const View& view, std::size_t width, std::size_t height, Margins margins);

    // What is seen includes all of this scene, and of those that were included before.
    void include(const Scene& scene);
    // Moves the camera to where all that was included fits. Without anything: around the origin.
    void fit();
    // Instead: margins and zoom count for nothing. With parallel rays, all that was included is in front.
    void aim(const Aim& at);

    struct Ray {
        Vec from, along;  // Of length 1.
    };
    // Through a place of the picture, in pixels from its upper left corner.
    Ray ray(float x, float y) const;
    struct Pixel {
        float x, y;      // As above.
        float distance;  // From where the ray of this pixel begins.
    };
    Pixel project(const Vec& at) const;
    // Pixels to a catom diameter, in the middle of what is seen.
    float scale() const { return static_cast<float>(height_) / (2 * half_height_); }
    bool parallel() const { return tangent_ == 0; }
    float tangent() const { return tangent_; }  // Of half the angle across the height.
    const Vec& right() const { return right_; }
    const Vec& forward() const { return forward_; }
    // Of what was included, across.
    float extent() const { return (high_ - low_).maxCoeff(); }

  private:
    Vec right_, up_, forward_;  // Of length 1, at right angles.
    float tangent_ = 0;         // Of half the angle; 0: parallel rays.
    float aspect_, zoom_;
    std::size_t width_, height_;
    // The edges of what is kept free, from the middle of the picture, as fractions of half its width or height.
    float left_, right_edge_, top_, bottom_;
    // How far what is included reaches along right, up and forward; and how far the planes through its outermost points are from the
    // origin that will meet the edges of the picture, for rays from one point.
    Eigen::Array3f low_, high_;
    Eigen::Array2f most_, least_;
    bool any_ = false;
    Vec eye_ = Vec::Zero();  // Where rays begin; for parallel ones, that of the middle of the picture.
    float half_height_ = 1;  // Of the picture, in catom diameters, at the middle of what is seen.
};

}  // namespace meld::render
