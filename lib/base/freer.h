// Objects of C libraries in std::unique_ptr.
#pragma once

namespace tessera::base {

/// A deleter that calls `kFree`: std::unique_ptr<X509, Freer<X509_free>>.
template <auto kFree>
struct Freer {
  template <class T>
  void operator()(T* object) const {
    kFree(object);
  }
};

}  // namespace tessera::base
