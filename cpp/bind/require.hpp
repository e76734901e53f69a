// Checks of arguments: what is not right is told to Python as a ValueError.
#pragma once

#include <stdexcept>
#include <string>

namespace dlpoly::bind {

inline void require(bool condition, const std::string& message) {
    if (!condition) {
        throw std::invalid_argument(message);
    }
}

}  // namespace dlpoly::bind
