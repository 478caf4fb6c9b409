"""The suite: every case against theory, other formulations and other engines, and one report (``mbsd3d validate``).

trial        a case: a mechanism, how it is run, who judges it       references, demonstrations, engines, random
findings     what a judge says; the record of a case                 ledger keeps records, so a killed run goes on
suite        runs all trials; table, page and document show them
"""
