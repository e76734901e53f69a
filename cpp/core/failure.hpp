// The one exception with which a running simulation stops; the bindings turn it into pydlpoly.errors.RunError.
#pragma once

#include <stdexcept>

namespace dlpoly {

class RunFailure : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

}  // namespace dlpoly
