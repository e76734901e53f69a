// Turns the four switches of a Variant into the template that was compiled for them.
#pragma once

#include "fast/arguments.hpp"

// One expression a combination; NAME is a template <class Record, bool one_kind, bool drag, bool observe, bool last>.
// Without drag, passes that are not the last are never observed.
#define DLPOLY_CHOOSE_PASS_OF(NAME, RECORD, variant, KIND)                                             \
    ((variant).drag ? ((variant).last ? ((variant).observe ? &NAME<RECORD, KIND, true, true, true>     \
                                                           : &NAME<RECORD, KIND, true, false, true>)   \
                                      : ((variant).observe ? &NAME<RECORD, KIND, true, true, false>    \
                                                           : &NAME<RECORD, KIND, true, false, false>)) \
                    : ((variant).last ? ((variant).observe ? &NAME<RECORD, KIND, false, true, true>    \
                                                           : &NAME<RECORD, KIND, false, false, true>)  \
                                      : &NAME<RECORD, KIND, false, false, false>))
#define DLPOLY_CHOOSE_PASS(NAME, RECORD, variant)                            \
    ((variant).one_kind ? DLPOLY_CHOOSE_PASS_OF(NAME, RECORD, variant, true) \
                        : DLPOLY_CHOOSE_PASS_OF(NAME, RECORD, variant, false))
