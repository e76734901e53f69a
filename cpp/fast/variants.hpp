// Turns the four switches of a Variant into the template that was compiled for them.
#pragma once

#include "fast/arguments.hpp"

// One expression a combination; NAME is a template <class Record, bool one_kind, bool drag, bool observe, bool last>.
#define DLPOLY_CHOOSE_PASS(NAME, RECORD, variant)                                                             \
    ((variant).one_kind                                                                                       \
         ? ((variant).drag ? ((variant).last ? ((variant).observe ? &NAME<RECORD, true, true, true, true>     \
                                                                  : &NAME<RECORD, true, true, false, true>)   \
                                             : &NAME<RECORD, true, true, false, false>)                       \
                           : ((variant).last ? ((variant).observe ? &NAME<RECORD, true, false, true, true>    \
                                                                  : &NAME<RECORD, true, false, false, true>)  \
                                             : &NAME<RECORD, true, false, false, false>))                     \
         : ((variant).drag ? ((variant).last ? ((variant).observe ? &NAME<RECORD, false, true, true, true>    \
                                                                  : &NAME<RECORD, false, true, false, true>)  \
                                             : &NAME<RECORD, false, true, false, false>)                      \
                           : ((variant).last ? ((variant).observe ? &NAME<RECORD, false, false, true, true>   \
                                                                  : &NAME<RECORD, false, false, false, true>) \
                                             : &NAME<RECORD, false, false, false, false>)))
