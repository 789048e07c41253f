// The few pieces of SVG that the pictures are made of. Coordinates are pixels, y down.
#pragma once

#include <cstdint>
#include <string>

#include "Eigen/Core"

namespace hpgo {

// A pixel coordinate with at most one decimal: "12.3", "12", "-.5".
std::string SvgNumber(double value);

// `text` with & < > and quotes as entities and control characters as spaces.
std::string SvgEscape(const std::string& text);

// The `d` attribute of a path, one decimal, relative steps: about 6 bytes a point. Steps are taken
// between rounded points, so that errors do not add up.
class SvgPath {
 public:
  void MoveTo(const Eigen::Vector2d& point);
  // A point that rounds to the last one is left out.
  void LineTo(const Eigen::Vector2d& point);
  // MoveTo and a LineTo that is kept even if its length is zero, so that a round cap shows.
  void Segment(const Eigen::Vector2d& from, const Eigen::Vector2d& to);

  bool empty() const { return data_.empty(); }
  const std::string& data() const { return data_; }

 private:
  void Step(char command, std::int64_t x, std::int64_t y);

  std::string data_;
  char command_ = 0;
  std::int64_t x_ = 0;  // tenths of a pixel
  std::int64_t y_ = 0;
};

// <text> with its baseline at `at`; `attributes` as in "class=\"title\"".
std::string SvgText(const Eigen::Vector2d& at, const std::string& attributes,
                    const std::string& text);

// <svg> with a light rounded background, so that the picture reads on a dark page too, and the
// style sheet of all pictures.
std::string SvgDocument(double width, double height, const std::string& title,
                        const std::string& body);

}  // namespace hpgo
