"""The reference model on arrays: many trials or steps, one in each lane, computed side by side.

There is one model, `heatwright.sim.reference`, written for one controller. Here its modules' syntax
trees are translated so that each number may be an array with one element for each lane. Where an
`if` is true for some lanes only, both branches run, each with the mask of its lanes; values of
other lanes stay unchanged. Each operation on an array is the IEEE 754 operation on its elements, in
the order of the model: so each lane equals the model bit for bit.

Code that cannot be translated raises an error. Kinds of statement that the model does not use are
refused by the translation; numpy refuses to use an array as one truth value; an `AllLanesError` is
raised if something that all lanes share, such as the length of a list, would change for some lanes
only. `world.step_logs` then runs the lanes one by one.

    modules    the translated modules, imported by the name of the original
    translate  syntax tree -> syntax tree
    masks      what the translated code calls
    builtin    min, int, floor and so on, for arrays
    stack      N objects of the model -> one whose numbers are arrays
    plant      N thermal networks as one
    world      N controllers on N machines
    steps      all steps of a log, each from the state before it
"""
