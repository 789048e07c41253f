#include "hpgo/report/svg.h"

#include <cmath>
#include <cstdlib>

namespace hpgo {
namespace {

constexpr double kTenths = 10;

std::string TenthsToString(std::int64_t tenths) {
  const std::int64_t size = std::abs(tenths);
  std::string text = tenths < 0 ? "-" : "";
  if (size >= 10 || size == 0) text += std::to_string(size / 10);
  if (size % 10 != 0) {
    text += '.';
    text += static_cast<char>('0' + size % 10);
  }
  return text;
}

std::int64_t ToTenths(double value) { return std::llround(value * kTenths); }

}  // namespace

std::string SvgNumber(double value) { return TenthsToString(ToTenths(value)); }

std::string SvgEscape(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      default:
        escaped += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
  }
  return escaped;
}

void SvgPath::Step(char command, std::int64_t x, std::int64_t y) {
  // The first move of a path is absolute even in lower case, because it starts at 0, 0.
  const std::string dx = TenthsToString(x - x_);
  const std::string dy = TenthsToString(y - y_);
  if (command != command_) {
    data_ += command;
  } else if (dx[0] != '-') {
    data_ += ' ';
  }
  data_ += dx;
  if (dy[0] != '-') data_ += ' ';
  data_ += dy;
  command_ = command;
  x_ = x;
  y_ = y;
}

void SvgPath::MoveTo(const Eigen::Vector2d& point) {
  command_ = 0;  // a repeated pair after "m" would be a line
  Step('m', ToTenths(point.x()), ToTenths(point.y()));
}

void SvgPath::LineTo(const Eigen::Vector2d& point) {
  const std::int64_t x = ToTenths(point.x());
  const std::int64_t y = ToTenths(point.y());
  if (x != x_ || y != y_) Step('l', x, y);
}

void SvgPath::Segment(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  MoveTo(from);
  Step('l', ToTenths(to.x()), ToTenths(to.y()));
}

std::string SvgText(const Eigen::Vector2d& at, const std::string& attributes,
                    const std::string& text) {
  return "<text x=\"" + SvgNumber(at.x()) + "\" y=\"" + SvgNumber(at.y()) + "\"" +
         (attributes.empty() ? "" : " ") + attributes + ">" + SvgEscape(text) + "</text>\n";
}

std::string SvgDocument(double width, double height, const std::string& title,
                        const std::string& body) {
  const std::string w = SvgNumber(width);
  const std::string h = SvgNumber(height);
  return "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + w + " " + h + "\" width=\"" +
         w + "\" height=\"" + h + "\" role=\"img\">\n" +
         (title.empty() ? "" : "<title>" + SvgEscape(title) + "</title>\n") +
         "<style>"
         "text{font-family:'Helvetica Neue',Helvetica,Arial,'Liberation Sans',sans-serif;"
         "font-size:13px;fill:#4a5361}"
         ".title{font-size:17px;font-weight:600;fill:#1c2430}"
         ".label{font-size:14px;font-weight:600;fill:#1c2430}"
         "path{fill:none;stroke-linecap:round;stroke-linejoin:round}"
         "</style>\n"
         "<rect width=\"" +
         w + "\" height=\"" + h + "\" rx=\"10\" fill=\"#fbfaf7\"/>\n" + body + "</svg>\n";
}

}  // namespace hpgo
