// SPDX-License-Identifier: Apache-2.0
#include <elf.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <link.h>

#include <algorithm>
#include <cstring>
#include <span>

#include "uwv/pipeline/environment.h"

namespace uwv {
namespace {

using Bytes = std::span<const unsigned char>;

std::size_t padded(std::size_t size) { return (size + 3) / 4 * 4; }

/// The build id among the notes of an ELF segment; empty if it is not there.
std::string id_among(Bytes notes) {
  ElfW(Nhdr) note;
  while (notes.size() >= sizeof note) {
    std::memcpy(&note, notes.data(), sizeof note);
    const std::size_t name_size = padded(note.n_namesz), whole = sizeof note + name_size + padded(note.n_descsz);
    if (whole > notes.size()) break;
    const Bytes name = notes.subspan(sizeof note, note.n_namesz);
    if (note.n_type == NT_GNU_BUILD_ID &&
        std::ranges::equal(name, Bytes(reinterpret_cast<const unsigned char*>("GNU"), 4)))
      return fmt::format("{:02x}", fmt::join(notes.subspan(sizeof note + name_size, note.n_descsz), ""));
    notes = notes.subspan(whole);
  }
  return "";
}

struct Search {
  ElfW(Addr) address;  ///< Somewhere in the module that is looked for.
  std::string id;
};

int look_into(dl_phdr_info* module, std::size_t, void* data) {
  auto& search = *static_cast<Search*>(data);
  const std::span<const ElfW(Phdr)> segments(module->dlpi_phdr, module->dlpi_phnum);
  const bool holds_us = std::ranges::any_of(segments, [&](const ElfW(Phdr) & s) {
    const ElfW(Addr) start = module->dlpi_addr + s.p_vaddr;
    return s.p_type == PT_LOAD && search.address >= start && search.address - start < s.p_memsz;
  });
  if (!holds_us) return 0;
  for (const ElfW(Phdr) & s : segments)
    if (s.p_type == PT_NOTE && search.id.empty())
      search.id = id_among({reinterpret_cast<const unsigned char*>(module->dlpi_addr + s.p_vaddr), s.p_memsz});
  return 1;
}

}  // namespace

std::string build_id() {
  static const char somewhere_in_here = 0;
  Search search{reinterpret_cast<ElfW(Addr)>(&somewhere_in_here), ""};
  dl_iterate_phdr(look_into, &search);
  return search.id;
}

}  // namespace uwv
