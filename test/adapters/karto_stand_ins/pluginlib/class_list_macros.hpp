// A stand-in: the plugin's class derives from its base and can be made.
#pragma once

#include <type_traits>

#define PLUGINLIB_EXPORT_CLASS(Class, Base)              \
  static_assert(std::is_base_of<Base, Class>::value, ""); \
  static_assert(std::is_default_constructible<Class>::value, "");
