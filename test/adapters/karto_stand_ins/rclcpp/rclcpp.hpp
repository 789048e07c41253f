// Stand-ins for the parts of rclcpp that the plugin uses.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <variant>

namespace rclcpp {

struct Logger {};

class Parameter {
 public:
  using Value = std::variant<bool, int64_t, double, std::string>;
  explicit Parameter(Value value) : value_(std::move(value)) {}
  double as_double() const { return std::get<double>(value_); }
  const std::string& as_string() const { return std::get<std::string>(value_); }

 private:
  Value value_;
};

class Node {
 public:
  using SharedPtr = std::shared_ptr<Node>;
  std::map<std::string, Parameter::Value> overrides;

  bool has_parameter(const std::string& name) const { return declared_.count(name) > 0; }
  template <typename T>
  T declare_parameter(const std::string& name, const T& value) {
    const auto it = overrides.find(name);
    declared_[name] = it == overrides.end() ? Parameter::Value(value) : it->second;
    return std::get<T>(declared_[name]);
  }
  Parameter get_parameter(const std::string& name) const { return Parameter(declared_.at(name)); }
  Logger get_logger() const { return {}; }

 private:
  std::map<std::string, Parameter::Value> declared_;
};

}  // namespace rclcpp

#define RCLCPP_ERROR(logger, ...)     \
  do {                                \
    (void)(logger);                   \
    std::fprintf(stderr, __VA_ARGS__); \
  } while (false)
#define RCLCPP_WARN RCLCPP_ERROR
