"""Lines of the display's C broken one by one, each with the test that must notice."""

from typing import NamedTuple


class Mutant(NamedTuple):
    """A line of a file, what it becomes, and the test that fails then."""

    file: str
    old: str
    new: str
    test: str


FRAME = [
    ("byte == ';'", "byte == ':'", "orders.the_switch_and_the_duty_by_hand"),
    ("length == NEXTION_ORDER_SIZE", "false", "orders.an_order_too_long_is_dropped"),
    ("        inside = true;\n        length = 0;", "        inside = true;",
     "orders.a_cut_order_is_replaced_by_the_next"),
    ("    if (byte == ';') {\n        inside = false;", "    if (byte == ';') {",
     "orders.a_cut_order_is_replaced_by_the_next"),
    ("end[0] != END || end[1] != END", "false", "shows.other_answers"),
    ("answer[0] == 0 && answer[1] == 0 && answer[2] == 0", "answer[2] == 0", "shows.other_answers"),
    ("answer[2] == ANSWER_LOST", "false", "shows.everything_again_when_the_display_has_lost"),
    ("frame_page = answer[2];", "frame_page = answer[3];", "shows.the_display_answers_which_page"),
]  # fmt: skip
NUMBERS = [
    ("if (value > most) {", "if (false) {", "orders.malformed"),
    ("        if (number->digits > MOST_BEFORE_DIGIT) {", "        if (false) {",
     "orders.malformed"),
    ("        if (number.digits > MOST_BEFORE_DIGIT) {", "        if (false) {", "points.unsound"),
    ("    return any;\n}\n\nbool number_whole", "    return true;\n}\n\nbool number_whole",
     "orders.malformed"),
    ("*at >= '5'", "false", "points.each_kind"),
    ("up = more ? up : ", "up = ", "points.each_kind"),
    ("    if (written.negative) {", "    if (false) {", "orders.malformed"),
]  # fmt: skip
POINTS = [
    ("point->number > PROGRAM_POINTS)", "false)", "points.unsound"),
    ("point->number == 0 ||", "", "points.unsound"),
    ("|| point->hundredths < 0\n", "\n", "points.unsound"),
    ("|| point->tenths > LARGEST_TENTHS", "", "points.unsound"),
    ("|| !programs_are_sound(changed)", "", "points.unsound"),
    ("**text != ':' ||", "", "points.unsound"),
    ("point->number > in->segments + 1u", "false", "points.what_was_taken_away"),
    ("return in->segment[i].to_dc == tenths;", "return false;", "points.the_end_of_before"),
    ("    if (!has_target(segment->kind)) {", "    if (false) {", "points.each_kind"),
    ("    write_wanted = true;", "", "points.a_change_outlives"),
    ("in->segments = (uint8_t)(point->number - 1u);", "", "points.the_end_is_moved"),
    ("* 6u + 5u) / 10u", "* 6u) / 10u", "points.each_kind"),
    ("strlen(text) >= PROGRAM_NAME_SIZE || ", "", "orders.malformed"),
    ("|| strspn(text, \" \") == strlen(text)", "", "orders.malformed"),
    ("    points_marked = 0;\n", "", "orders.a_mark_goes"),
]  # fmt: skip
ORDERS = [
    ("number_whole(&text, most, count) && *text == '\\0'", "number_whole(&text, most, count)",
     "orders.malformed"),
    ("number_float(&text, number) && *text == '\\0'", "number_float(&text, number)",
     "orders.malformed"),
    ("!(value >= 0.0f && value <= GAIN_MAXIMUM)", "!(value >= 0.0f)", "orders.malformed"),
    ("!(value >= 0.0f && value <= GAIN_MAXIMUM)", "!(value <= GAIN_MAXIMUM)", "orders.malformed"),
    ("    loop_chamber_disable();", "    (void)0;", "orders.off_stops_a_program"),
    ("    loop_chamber_set_automatic();", "", "orders.the_switch_and_the_duty"),
    ("        fault_acknowledge();", "", "orders.a_fault_is_acknowledged"),
    ("return run ? program_resume() : program_pause();", "return program_pause();",
     "orders.run_pause"),
    ("    pages_want(PAGE_POINTS);", "", "shows.a_program_comes_up"),
    ("        settings_keep_chamber();", "", "orders.gains_are_kept"),
]  # fmt: skip
PAGES = [
    ("    tries_left--;", "", "shows.a_page_that_is_not_seen"),
    ("        wanted = NO_PAGE;", "", "shows.a_page_that_is_seen"),
    ("    beats_to_try = BEATS_OF_TRY;", "", "shows.a_page_that_is_not_seen"),
    ("is_of_fault(pages_shown) ||", "", "shows.after_the_acknowledgement_the_main_page_comes"),
    ("|| pages_shown == PAGE_MAIN", "", "shows.after_the_acknowledgement_the_main_page_begins"),
    ("    pages_shown = page;", "", "shows.the_display_answers"),
    ("    show_anew();", "", "shows.the_display_answers"),
    ("    chart_show(page);", "", "shows.the_chart_of_the_firing"),
    ("(tries_left != 0 || beats_to_try != 0)", "false", "shows.a_page_that_goes"),
    ("    pages_note(PAGE_MAIN);\n    if (fault.code != FAULT_NONE) {",
     "    pages_note(PAGE_MAIN);\n    if (false) {", "shows.the_page_of_a_fault_comes_again"),
]  # fmt: skip
SHOW = [
    ("if (is_said[place] && said[place] == number)", "if (false)", "shows.a_change_is_said"),
    (" && said[place] == number)", ")", "shows.a_change_is_said"),
    ("    memset(is_said, 0, sizeof is_said);", "", "shows.everything_again_every"),
    ("row <= points_shown.segments", "true", "shows.what_was_taken_away"),
    ("seen_step != loop_chamber.steps", "false", "shows.a_change_is_said"),
    ("in_all != shown->in_all", "false", "shows.clocks"),
    ("+ program.ended", "", "shows.the_state_in_words"),
    ("->amount * KINDS + segment(row)->kind", "->amount * KINDS", "shows.a_program_is_shown"),
]  # fmt: skip
CHART = [
    ("pixels < (float)NEXTION_CHART_HEIGHT ?", "true ?", "shows.a_chart_ends"),
    ("!(pixels >= 0.0f)", "false", "shows.a_chart_ends"),
    ("    if (size < NEXTION_CHART_COLUMNS) {\n        size++;\n    }", "    size++;",
     "shows.a_chart_that_is_full"),
    ("% NEXTION_CHART_COLUMNS);\n    if (size", "% 65536u);\n    if (size",
     "shows.a_chart_that_is_full"),
    ("    to_clear = CHANNELS;", "", "shows.the_chart_of_the_firing"),
    ("        left = size;", "", "shows.the_chart_of_the_firing"),
]  # fmt: skip
TALK = [
    ("            (void)orders_do(frame_text);\n            show_anew();",
     "            (void)orders_do(frame_text);", "shows.a_button_is_put_right"),
    ("of it */\n            return;", "of it */\n            break;", "orders.one_order"),
    ("    set_up--;", "", "shows.it_begins"),
    ("page < NEXTION_PAGES && page != pages_shown", "page != pages_shown", "shows.other_answers"),
    ("    beats_to_refresh--;", "", "shows.everything_again_every"),
    ("            pages_start();", "", "shows.everything_again_when_the_display_starts"),
    ("        beat();", "", "shows.everything_again_every"),
    ("        chart_clear();", "", "shows.the_chart_of_the_firing"),
    ("|| pages_are_turning()", "", "shows.a_page_that_goes"),
]  # fmt: skip
PORT = [
    ("    if (room == 0) {", "    if (false) {", "hostile.a_flood"),
    ("    if (room == 1) {", "    if (false) {", "orders.an_order_that_the_ring_cuts"),
    ("intact ? data : NEXTION_PORT_DAMAGED", "data", "orders.a_damaged_byte"),
    ("(1u << FE0) |", "", "orders.a_damaged_byte"),
]  # fmt: skip
SAY = [
    ("    if (length < SAY_SIZE) {", "    if (length < 20) {", "shows.the_list_of_faults"),
    ("if (number < 0) {", "if (false) {", "shows.below_zero"),
    ("behind % 10u == 0", "false", "shows.a_program_is_shown"),
]  # fmt: skip

MUTANTS = [
    Mutant(f"nextion_{stem}.c" if stem else "nextion.c", *line)
    for stem, lines in {
        "frame": FRAME, "numbers": NUMBERS, "points": POINTS, "orders": ORDERS, "pages": PAGES,
        "show": SHOW, "chart": CHART, "talk": TALK, "port": PORT, "say": SAY,
    }.items()
    for line in lines
]  # fmt: skip
MUTANTS += [
    Mutant("nextion.c", "    ticks_left--;", "", "shows.it_begins"),
    Mutant("nextion.c", "ticks_left = NEXTION_TURN_TICKS;\n        talk_turn", "ticks_left = 1;\n"
           "        talk_turn", "shows.no_instruction_follows"),
    Mutant("fault_log.c", "% FAULT_LOG_SIZE);\n    entries", "% 256u);\n    entries",
           "shows.the_list_of_faults"),
    Mutant("fault_log.c", "&& fault.acknowledgements == seen_acknowledgements", "",
           "shows.the_same_fault_again"),
    Mutant("fault_log.c", "    if (index >= size) {", "    if (0) {",
           "shows.the_same_fault_again"),
]  # fmt: skip
