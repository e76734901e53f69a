// An array of fixed size at the start of a cache line, zeros at first.
#pragma once

#include <cstddef>
#include <cstring>
#include <new>
#include <utility>

namespace dlpoly::fast {

template <class T>
class AlignedArray {
  public:
    explicit AlignedArray(std::size_t count)
        : size_(count), data_(static_cast<T*>(::operator new(count * sizeof(T), std::align_val_t{64}))) {
        std::memset(static_cast<void*>(data_), 0, count * sizeof(T));
    }
    AlignedArray(const AlignedArray&) = delete;
    AlignedArray& operator=(const AlignedArray&) = delete;
    AlignedArray(AlignedArray&&) = delete;
    AlignedArray& operator=(AlignedArray&&) = delete;
    ~AlignedArray() { ::operator delete(data_, std::align_val_t{64}); }
    T* data() noexcept { return data_; }
    const T* data() const noexcept { return data_; }
    [[nodiscard]] std::size_t size() const noexcept { return size_; }
    void swap(AlignedArray& other) noexcept {
        std::swap(size_, other.size_);
        std::swap(data_, other.data_);
    }

  private:
    std::size_t size_;
    T* data_;
};

}  // namespace dlpoly::fast
